// The actions that can have a key, and their keys.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gestures/tools.h"
#include "platform/window.h"

namespace knead::studio {

enum class Action {
  new_shape,
  open,
  add_shape,
  save,
  save_as,
  export_shape,
  export_frames,
  picture,
  poster,
  turntable,
  stamp_file,
  reference_image,
  recover,
  quit,
  undo,
  redo,
  cancel,
  finish,
  radius,
  inner_ratio,
  larger,
  smaller,
  rounder,
  sharper,
  drag_mode,
  paint_in,
  mirror_x,
  mirror_y,
  mirror_z,
  remesh,
  mask_fill,
  mask_clear,
  mask_invert,
  mask_blur,
  mask_grow,
  mask_shrink,
  hide_masked,
  hide_unmasked,
  show_all,
  remesh_last,
  fit,
  frame_all,
  frame_stroke,
  view_front,
  view_back,
  view_right,
  view_left,
  view_top,
  view_bottom,
  keep_view,
  kept_view,
  projection,
  wireframe,
  shading,
  next_matcap,
  cavity,
  occlusion,
  background,
  references,
  influence,
  region,
  stretch,
  cutting_plane,
  help,
  panels,
  history,
  statistics,
  tool_labels,
  full_screen,
  search,
  welcome,
  tour,
  first_tool,  // this and those that follow choose a tool, in the order of studio_tools()
};

// Returns all actions, each once, in the order of the help.
std::span<const Action> all_actions();

// Returns the action that chooses a tool, and the tool that an action chooses (a null pointer for other actions).
Action action_of(const StudioTool& tool);
const StudioTool* tool_of(Action action);

// A key with the modifiers held. A letter is the one printed on the key; other keys are named by their places on a US
// keyboard: see key_names().
struct Chord {
  std::string key;
  Modifiers modifiers{};

  friend bool operator==(const Chord&, const Chord&) = default;
};

// Returns the chord as text: "Ctrl+Shift+Z", "Numpad 5", "Alt+[".
std::string text_of(const Chord& chord);

// Returns the chord of a text, in upper or lower case and with modifiers in any order; nothing for an unknown name.
std::optional<Chord> chord_of(std::string_view text);

// Returns the names of all keys: "A" to "Z", "0" to "9", "F1" to "F12", "[", "Space", "Escape", "Numpad 1", "Home", ...
std::span<const std::string_view> key_names();

// Return the name of an action in the configuration file ("save_as"), its title in menus ("Save as..."), and the action
// with a name.
std::string_view name_of(Action action);
std::string_view title_of(Action action);
std::optional<Action> action_named(std::string_view name);

// Returns the heading of the help that lists an action: "File", "Edit", "Tools", "View" or "Window".
std::string_view group_of(Action action);

// The chords of each action; no chord belongs to two.
struct KeyMap {
  std::vector<std::vector<Chord>> chords{all_actions().size()};

  const std::vector<Chord>& of(Action action) const { return chords[static_cast<std::size_t>(action)]; }
  std::vector<Chord>& of(Action action) { return chords[static_cast<std::size_t>(action)]; }

  friend bool operator==(const KeyMap&, const KeyMap&) = default;
};

KeyMap default_keys();

// Returns the action of a chord; nothing if it has none.
std::optional<Action> action_of(const KeyMap& keys, const Chord& chord);

// Returns the keys of an action for menus: "Ctrl+Z", "H or F1"; empty if it has none.
std::string keys_text(const KeyMap& keys, Action action);

// One line of a configuration: an action, and its only chords.
struct KeyChoice {
  std::string action;
  std::vector<std::string> chords;
};

// Changes the map by these lines. A chord is removed from the action that has it by default. Returns a sentence for
// each line or chord that is ignored (unknown, or given twice), and for each action that lost its only key to another
// one.
std::vector<std::string> choose_keys(KeyMap& keys, std::span<const KeyChoice> choices);

// --- search of commands ----------------------------------------------------------------------------

// Returns the actions in whose title, group or name every word of the text occurs, in upper or lower case: first those
// whose title begins with the text, then those with a word that begins with its first word, then the others. Returns
// all actions for a text without words.
std::vector<Action> found_actions(std::string_view text);

}  // namespace knead::studio
