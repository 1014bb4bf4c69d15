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

// A key with the modifiers held. A letter is the one printed on the key; another key's name is that of its place on a
// US keyboard: see key_names().
struct Chord {
  std::string key;
  Modifiers modifiers{};

  friend bool operator==(const Chord&, const Chord&) = default;
};

// "Ctrl+Shift+Z", "Numpad 5", "Alt+[".
std::string text_of(const Chord& chord);

// The other way, in upper or lower case and with modifiers in any order; nothing where a name is not known.
std::optional<Chord> chord_of(std::string_view text);

// Every key that there is: "A" to "Z", "0" to "9", "F1" to "F12", "[", "Space", "Escape", "Numpad 1", "Home", ...
std::span<const std::string_view> key_names();

// How an action is named: in the configuration file ("save_as"), and by a person ("Save as...").
std::string_view name_of(Action action);
std::string_view title_of(Action action);
std::optional<Action> action_named(std::string_view name);

// Under which heading of the help an action stands: "File", "Edit", "Tools", "View" or "Window".
std::string_view group_of(Action action);

// The chords of each action; no chord belongs to two.
struct KeyMap {
  std::vector<std::vector<Chord>> chords{all_actions().size()};

  const std::vector<Chord>& of(Action action) const { return chords[static_cast<std::size_t>(action)]; }
  std::vector<Chord>& of(Action action) { return chords[static_cast<std::size_t>(action)]; }

  friend bool operator==(const KeyMap&, const KeyMap&) = default;
};

KeyMap default_keys();

// What the key asks for.
std::optional<Action> action_of(const KeyMap& keys, const Chord& chord);

// What a person reads beside an action: "Ctrl+Z", "H or F1"; empty for none.
std::string keys_text(const KeyMap& keys, Action action);

// One line of a configuration: the action of that name is to have these chords and no others.
struct KeyChoice {
  std::string action;
  std::vector<std::string> chords;
};

// Changes the map by these lines. A chord is taken away from the action that has it by default. Returns a sentence for
// each line or chord that could not be used (unknown, or given twice), and for each action that was left without a key
// by another one; the rest is used all the same.
std::vector<std::string> choose_keys(KeyMap& keys, std::span<const KeyChoice> choices);

// --- commands found by what a person types
// ----------------------------------------------------------------------------

// Returns the actions in whose title, group or name every word of the text occurs, in upper or lower case: first those
// whose title begins with the text, then those with a word that begins with its first word, then the others. All
// actions if the text holds no word.
std::vector<Action> found_actions(std::string_view text);

}  // namespace knead::studio
