// A window with an OpenGL context, and what a person does at it as plain values: the window sends them, and so does a
// script.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

struct GLFWwindow;

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

// --- the window
// -------------------------------------------------------------------------------------------------------

struct WindowState;

// How large a window is.
struct WindowPlace {
  int width = 1440;  // in points; of a maximised window, as it is when it is restored
  int height = 900;
  bool maximized = false;

  friend bool operator==(const WindowPlace&, const WindowPlace&) = default;
};

class Window {
 public:
  // A window with a core context, 4.3 where there is one, else 3.3, current in this thread. Throws std::runtime_error,
  // one line, where there is no display or no such OpenGL.
  Window(const std::string& title, const WindowPlace& place);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // What happened since the last call, in order; movements of the pointer that follow each other are one. Waits up to
  // `wait_seconds` for something to happen.
  std::vector<Event> events(double wait_seconds);

  // Whether the person wants it closed. May be taken back.
  bool is_closing() const;
  void set_closing(bool closing);

  void set_title(const std::string& title);
  void toggle_full_screen();

  // As it is to be opened the next time: its size outside full screen.
  WindowPlace place() const;

  // Of the picture, in pixels; zero where it is minimised.
  int width() const;
  int height() const;

  // How much larger than on an ordinary display texts are to be, in pixels of the picture.
  double scale() const;

  // Shows what was drawn; waits for the display.
  void show();

  // For Dear ImGui, which is told of everything before it becomes an event here.
  GLFWwindow* handle() const { return window_; }

 private:
  GLFWwindow* window_ = nullptr;
  std::unique_ptr<WindowState> state_;
};

// The pressure of a pen. GLFW 3.3 does not report it; on X11 the extension XInput2 does (docs/decisions/0019), on
// Windows the messages of Windows Ink. On X11 it follows the devices of the display on a connection of its own.
// Elsewhere, and without the extension, there is no pen.
class Pen {
 public:
  Pen();
  ~Pen();
  Pen(const Pen&) = delete;
  Pen& operator=(const Pen&) = delete;

  // Returns the pressure, from 0 to 1, of the device that moved last; 1 if that has no axis for it.
  double pressure();

 private:
  struct State;
  std::unique_ptr<State> state_;  // null: no pen can be followed
};

// Dear ImGui in a window: what happens at the window goes to it, and OpenGL draws it. Lives while a Gui and the window
// do.
class GuiBackend {
 public:
  explicit GuiBackend(Window& window);
  ~GuiBackend();
  GuiBackend(const GuiBackend&) = delete;
  GuiBackend& operator=(const GuiBackend&) = delete;

  // To be called before Gui::begin_frame, and after Gui::end_frame.
  void begin_frame(const Window& window);
  void draw();
};

}  // namespace knead::studio
