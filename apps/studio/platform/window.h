// A window with an OpenGL context, and what a person does at it as events.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "platform/event.h"

struct GLFWwindow;

namespace knead::studio {

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
  // so many seconds for something to happen.
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

}  // namespace knead::studio
