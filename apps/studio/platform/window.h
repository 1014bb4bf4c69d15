// A window with an OpenGL context, and its events as plain values, which windows and scripts send.
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

// The size of a window.
struct WindowPlace {
  int width = 1440;  // in points; of a maximised window, its size when restored
  int height = 900;
  bool maximized = false;

  friend bool operator==(const WindowPlace&, const WindowPlace&) = default;
};

class Window {
 public:
  // Opens a window with a core context, 4.3 if possible, else 3.3, current in this thread. Throws std::runtime_error,
  // one line, without a display or such an OpenGL.
  Window(const std::string& title, const WindowPlace& place);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // Returns the events since the last call, in order; consecutive movements of the pointer are one. Waits up to
  // `wait_seconds` for an event.
  std::vector<Event> events(double wait_seconds);

  // Whether the user has asked to close the window. set_closing(false) cancels that.
  bool is_closing() const;
  void set_closing(bool closing);

  void set_title(const std::string& title);
  void toggle_full_screen();

  // Returns the size for the next start: the size outside full screen.
  WindowPlace place() const;

  // The size of the picture, in pixels; zero if the window is minimised.
  int width() const;
  int height() const;

  // Returns the display's scale of texts, in pixels of the picture; 1 for an ordinary display.
  double scale() const;

  // Returns whether the user points by fingers, mainly.
  bool has_touch() const;

  // Shows what was drawn; waits for the display.
  void show();

  // Returns the handle for Dear ImGui, which gets everything before it becomes an event here.
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

// Connects Dear ImGui to a window: passes on the window's events, and draws by OpenGL. The Gui and the window must
// outlive it.
class GuiBackend {
 public:
  explicit GuiBackend(Window& window);
  ~GuiBackend();
  GuiBackend(const GuiBackend&) = delete;
  GuiBackend& operator=(const GuiBackend&) = delete;

  // Call begin_frame() before Gui::begin_frame, and draw() after Gui::end_frame.
  void begin_frame(const Window& window);
  void draw();
};

}  // namespace knead::studio
