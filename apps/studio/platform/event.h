// What a person does at the window, as plain values: the window sends them, and so does a script.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace knead::studio {

struct Modifiers {
  bool shift = false;
  bool ctrl = false;
  bool alt = false;

  friend bool operator==(const Modifiers&, const Modifiers&) = default;
};

enum class MouseButton { left, middle, right };

// Places are pixels of the view from its upper left corner, to the right and down.
struct PointerMoved {
  double x = 0;
  double y = 0;
  double pressure = 1;  // of a pen, 0 to 1
  Modifiers modifiers{};
};

struct ButtonChanged {
  MouseButton button = MouseButton::left;
  bool down = false;
  double x = 0;
  double y = 0;
  Modifiers modifiers{};
  bool is_double = false;  // the second press of a double click
};

struct WheelTurned {
  double steps = 0;  // away from the person: positive
  Modifiers modifiers{};
};

// The key by its name on a US keyboard: "A", "1", "F3", "[", "Space", "Escape", "Numpad 1", "Home" (keys.h).
struct KeyChanged {
  std::string key;
  bool down = false;
  Modifiers modifiers{};
};

struct FilesDropped {
  std::vector<std::filesystem::path> files;
};

struct Resized {
  int width = 0;
  int height = 0;
};

using Event = std::variant<PointerMoved, ButtonChanged, WheelTurned, KeyChanged, FilesDropped, Resized>;

}  // namespace knead::studio
