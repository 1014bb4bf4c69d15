// Dear ImGui in a window: what happens at the window goes to it, and OpenGL draws it.
#pragma once

#include "platform/window.h"

namespace knead::studio {

// Lives while a Gui and the window do.
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
