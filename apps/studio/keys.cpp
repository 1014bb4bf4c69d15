// The table of actions and their keys.
#include "keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string>

namespace knead::studio {

namespace {

struct ActionInfo {
  Action action;
  std::string name;
  std::string title;
  std::string_view group;
  std::array<std::string_view, 2> chords;  // empty: none
  std::string_view also{};                 // other words by which a person may look for it
};

using enum Action;

// In the order of Action, up to the tools.
const std::vector<ActionInfo> kFixedActions{
    {new_shape, "new_shape", "New shape...", "File", {"Ctrl+N"}},
    {open, "open", "Open...", "File", {"Ctrl+O"}},
    {add_shape, "add_shape", "Add a shape...", "File", {"Ctrl+Alt+O"}},
    {save, "save", "Save", "File", {"Ctrl+S"}},
    {save_as, "save_as", "Save as...", "File", {"Ctrl+Shift+S"}},
    {export_shape, "export", "Export...", "File", {"Ctrl+E"}, "stl obj ply glb print"},
    {export_frames, "export_frames", "Export frames...", "File", {"Ctrl+Shift+E"}},
    {picture, "picture", "Picture...", "File", {"F12"}},
    {poster, "poster", "Poster...", "File", {"Ctrl+F12"}},
    {turntable, "turntable", "Record turntable...", "File", {"Shift+F12"}},
    {stamp_file, "stamp_file", "Stamp from a file...", "File", {"Ctrl+Shift+T"}},
    {reference_image, "reference_image", "Reference image...", "File", {"Ctrl+Alt+R"}},
    {recover, "recover", "Recover unsaved work...", "File", {"Ctrl+Shift+O"}},
    {quit, "quit", "Quit", "File", {"Ctrl+Q"}},
    {undo, "undo", "Undo", "Edit", {"Ctrl+Z"}},
    {redo, "redo", "Redo", "Edit", {"Ctrl+Shift+Z", "Ctrl+Y"}},
    {cancel, "cancel", "Cancel", "Edit", {"Escape"}},
    {finish, "finish", "Finish a curve", "Edit", {"Enter", "Numpad Enter"}},
    {radius, "radius", "Radius with the pointer", "Tools", {"F"}, "size resize brush"},
    {inner_ratio, "inner_ratio", "Inner ratio with the pointer", "Tools", {"Shift+F"}},
    {larger, "larger", "Larger radius", "Tools", {"]"}},
    {smaller, "smaller", "Smaller radius", "Tools", {"["}},
    {rounder, "rounder", "Smaller inner ratio", "Tools", {"Shift+["}},
    {sharper, "sharper", "Larger inner ratio", "Tools", {"Shift+]"}},
    {drag_mode, "drag_mode", "Next drag direction", "Tools", {"D"}},
    {paint_in, "paint_in", "Press in or pull out", "Tools", {"I"}},
    {mirror_x, "mirror_x", "Mirror in x", "Tools", {"Alt+X"}, "symmetry"},
    {mirror_y, "mirror_y", "Mirror in y", "Tools", {"Alt+Y"}, "symmetry"},
    {mirror_z, "mirror_z", "Mirror in z", "Tools", {"Alt+Z"}, "symmetry"},
    {remesh, "remesh", "Remesh when a drag ends", "Tools", {"R"}, "dyntopo subdivide resolution detail triangles"},
    {mask_fill, "mask_fill", "Mask everything", "Tools", {"Ctrl+M"}},
    {mask_clear, "mask_clear", "Clear the mask", "Tools", {"Alt+M"}},
    {mask_invert, "mask_invert", "Invert the mask", "Tools", {"Ctrl+I"}},
    {mask_blur, "mask_blur", "Blur the mask", "Tools", {"Ctrl+B"}},
    {mask_grow, "mask_grow", "Grow the mask", "Tools", {"Ctrl+]"}},
    {mask_shrink, "mask_shrink", "Shrink the mask", "Tools", {"Ctrl+["}},
    {hide_masked, "hide_masked", "Hide what is masked", "Edit", {"Ctrl+H"}, "visibility"},
    {hide_unmasked, "hide_unmasked", "Hide what is not masked", "Edit", {"Shift+H"}, "isolate solo visibility"},
    {show_all, "show_all", "Show all", "Edit", {"Alt+H"}, "unhide reveal visibility"},
    {remesh_last, "remesh_last", "Remesh the last stroke", "Tools", {"Shift+R"}},
    {fit, "fit", "Fit to another shape...", "Tools", {"Ctrl+Shift+F"}},
    {frame_all, "frame_all", "Frame all", "View", {"Home"}, "zoom focus fit reset"},
    {frame_stroke, "frame_stroke", "Frame what is placed", "View", {"Numpad .", "."}},
    {view_front, "view_front", "From the front", "View", {"Numpad 1", "Alt+1"}},
    {view_back, "view_back", "From the back", "View", {"Ctrl+Numpad 1", "Ctrl+Alt+1"}},
    {view_right, "view_right", "From the right", "View", {"Numpad 3", "Alt+3"}},
    {view_left, "view_left", "From the left", "View", {"Ctrl+Numpad 3", "Ctrl+Alt+3"}},
    {view_top, "view_top", "From above", "View", {"Numpad 7", "Alt+7"}},
    {view_bottom, "view_bottom", "From below", "View", {"Ctrl+Numpad 7", "Ctrl+Alt+7"}},
    {keep_view, "keep_view", "Keep this view", "View", {"Ctrl+Alt+K"}, "bookmark camera store"},
    {kept_view, "kept_view", "Next kept view", "View", {"Alt+K"}, "bookmark camera recall"},
    {projection, "projection", "Perspective", "View", {"Numpad 5", "Alt+5"}},
    {wireframe, "wireframe", "Wireframe", "View", {"W"}},
    {shading, "shading", "Next shading", "View", {"S"}},
    {next_matcap, "next_matcap", "Next matcap", "View", {"Shift+S"}},
    {cavity, "cavity", "Cavity shading", "View", {"V"}},
    {occlusion, "occlusion", "Ambient occlusion", "View", {"Shift+V"}},
    {background, "background", "Next background", "View", {"Alt+B"}},
    {references, "references", "Reference images", "View", {"Alt+R"}},
    {influence, "influence", "Region of influence", "View", {"G"}},
    {region, "region", "Region at the cursor", "View", {"B"}},
    {stretch, "stretch", "Stretch of the surface", "View", {"Shift+G"}},
    {cutting_plane, "cutting_plane", "Cutting plane", "View", {"C"}},
    {help, "help", "Help", "Window", {"H", "F1"}},
    {panels, "panels", "Panels", "Window", {"Tab"}},
    {history, "history", "History", "Window", {"L"}, "layers undo"},
    {statistics, "statistics", "Statistics", "Window", {"T"}},
    {tool_labels, "tool_labels", "Names of the tools", "Window", {"Shift+T"}},
    {full_screen, "full_screen", "Full screen", "Window", {"F11"}},
    {search, "search", "Search commands...", "Window", {"F3"}},
    {welcome, "welcome", "Welcome...", "Window", {"Ctrl+F1"}},
    {tour, "tour", "Tour of one minute", "Window", {"Shift+F1"}},
};

// All, in the order of Action.
const std::vector<ActionInfo>& actions() {
  static const std::vector<ActionInfo> kActions = [] {
    std::vector<ActionInfo> all = kFixedActions;
    for (const StudioTool& tool : studio_tools()) {
      all.push_back({action_of(tool), "tool_" + word_of(tool), tool.name, "Tools", {tool.key}, tool.also});
    }
    return all;
  }();
  return kActions;
}

const ActionInfo& info(Action action) { return actions()[static_cast<std::size_t>(action)]; }

constexpr std::array<std::string_view, 95> kKeyNames{
    "A",         "B",         "C",        "D",        "E",        "F",        "G",
    "H",         "I",         "J",        "K",        "L",        "M",        "N",
    "O",         "P",         "Q",        "R",        "S",        "T",        "U",
    "V",         "W",         "X",        "Y",        "Z",        "0",        "1",
    "2",         "3",         "4",        "5",        "6",        "7",        "8",
    "9",         "F1",        "F2",       "F3",       "F4",       "F5",       "F6",
    "F7",        "F8",        "F9",       "F10",      "F11",      "F12",      "[",
    "]",         ",",         ".",        "/",        ";",        "'",        "`",
    "-",         "=",         "\\",       "Space",    "Escape",   "Enter",    "Tab",
    "Backspace", "Insert",    "Delete",   "Right",    "Left",     "Down",     "Up",
    "Page Up",   "Page Down", "Home",     "End",      "Pause",    "Numpad 0", "Numpad 1",
    "Numpad 2",  "Numpad 3",  "Numpad 4", "Numpad 5", "Numpad 6", "Numpad 7", "Numpad 8",
    "Numpad 9",  "Numpad .",  "Numpad /", "Numpad *", "Numpad -", "Numpad +", "Numpad Enter",
    "Shift",     "Ctrl",      "Alt",      "Menu"};

bool same_text(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

// Takes the prefix away from the text if it is there.
bool take(std::string_view& text, std::string_view prefix) {
  if (text.size() <= prefix.size() || !same_text(text.substr(0, prefix.size()), prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream(lower(std::string(text)));
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// 0 is best; 3: not found.
int rank_of(Action action, const std::vector<std::string>& words) {
  const std::string title = lower(std::string(title_of(action)));
  const std::string all =
      title + lower(fmt::format(" {} {} ", group_of(action), name_of(action))) + std::string(info(action).also);
  const bool has_all = std::all_of(words.begin(), words.end(),
                                   [&](const std::string& word) { return all.find(word) != std::string::npos; });
  if (!has_all) return 3;
  if (words.empty() || title.starts_with(words.front())) return 0;
  return title.find(" " + words.front()) != std::string::npos ? 1 : 2;
}

}  // namespace

std::span<const Action> all_actions() {
  static const std::vector<Action> kAll = [] {
    std::vector<Action> all;
    for (const StudioTool& tool : studio_tools()) all.push_back(action_of(tool));
    for (const ActionInfo& one : kFixedActions) all.push_back(one.action);
    return all;
  }();
  return kAll;
}

Action action_of(const StudioTool& tool) {
  return static_cast<Action>(static_cast<std::ptrdiff_t>(first_tool) + (&tool - studio_tools().data()));
}

const StudioTool* tool_of(Action action) {
  return action < first_tool ? nullptr
                             : &studio_tools()[static_cast<std::size_t>(action) - static_cast<std::size_t>(first_tool)];
}

std::string text_of(const Chord& chord) {
  return fmt::format("{}{}{}{}", chord.modifiers.ctrl ? "Ctrl+" : "", chord.modifiers.alt ? "Alt+" : "",
                     chord.modifiers.shift ? "Shift+" : "", chord.key);
}

std::optional<Chord> chord_of(std::string_view text) {
  Modifiers modifiers;
  for (;;) {
    if (take(text, "Ctrl+")) {
      modifiers.ctrl = true;
    } else if (take(text, "Alt+")) {
      modifiers.alt = true;
    } else if (take(text, "Shift+")) {
      modifiers.shift = true;
    } else {
      break;
    }
  }
  const auto* const name =
      std::find_if(kKeyNames.begin(), kKeyNames.end(), [&](std::string_view key) { return same_text(key, text); });
  if (name == kKeyNames.end()) return std::nullopt;
  return Chord{std::string(*name), modifiers};
}

std::span<const std::string_view> key_names() { return kKeyNames; }

std::string_view name_of(Action action) { return info(action).name; }

std::string_view title_of(Action action) { return info(action).title; }

std::string_view group_of(Action action) { return info(action).group; }

std::optional<Action> action_named(std::string_view name) {
  if (name == "tool_pins") return action_of(studio_tool(ToolUse::pose));  // its name until pose came
  for (const ActionInfo& info : actions()) {
    if (info.name == name) return info.action;
  }
  return std::nullopt;
}

KeyMap default_keys() {
  KeyMap keys;
  for (const ActionInfo& info : actions()) {
    for (const std::string_view text : info.chords) {
      if (const std::optional<Chord> chord = chord_of(text)) keys.of(info.action).push_back(*chord);
    }
  }
  return keys;
}

std::optional<Action> action_of(const KeyMap& keys, const Chord& chord) {
  for (const ActionInfo& info : actions()) {
    const std::vector<Chord>& chords = keys.of(info.action);
    if (std::find(chords.begin(), chords.end(), chord) != chords.end()) return info.action;
  }
  return std::nullopt;
}

std::string keys_text(const KeyMap& keys, Action action) {
  std::string text;
  for (const Chord& chord : keys.of(action)) text += (text.empty() ? "" : " or ") + text_of(chord);
  return text;
}

std::vector<std::string> choose_keys(KeyMap& keys, std::span<const KeyChoice> choices) {
  std::vector<std::string> messages;
  std::vector<bool> chosen(all_actions().size());
  for (const KeyChoice& choice : choices) {
    const std::optional<Action> action = action_named(choice.action);
    if (!action) {
      messages.push_back(
          fmt::format("keys: there is no action \"{}\"; docs/command.md lists the actions", choice.action));
      continue;
    }
    chosen[static_cast<std::size_t>(*action)] = true;
    keys.of(*action).clear();
  }
  for (const KeyChoice& choice : choices) {
    const std::optional<Action> action = action_named(choice.action);
    if (!action) continue;
    for (const std::string& text : choice.chords) {
      const std::optional<Chord> chord = chord_of(text);
      if (!chord) {
        messages.push_back(fmt::format("keys: \"{}\": there is no key \"{}\"", choice.action, text));
        continue;
      }
      const std::optional<Action> other = action_of(keys, *chord);
      if (other && chosen[static_cast<std::size_t>(*other)]) {
        messages.push_back(fmt::format("keys: {} is given to both \"{}\" and \"{}\"; it stays with the first",
                                       text_of(*chord), name_of(*other), choice.action));
        continue;
      }
      if (other && std::erase(keys.of(*other), *chord) > 0 && keys.of(*other).empty()) {
        messages.push_back(fmt::format("keys: \"{}\" takes {} away from \"{}\", which has no key now", choice.action,
                                       text_of(*chord), name_of(*other)));
      }
      keys.of(*action).push_back(*chord);
    }
  }
  return messages;
}

std::vector<Action> found_actions(std::string_view text) {
  const std::vector<std::string> words = words_of(text);
  std::vector<Action> found;
  for (int rank = 0; rank < 3; ++rank) {
    for (const Action action : all_actions()) {
      if (rank_of(action, words) == rank) found.push_back(action);
    }
  }
  return found;
}

}  // namespace knead::studio
