// Dear ImGui in a window: how it looks, and a frame of it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "knead/render/scene.h"
#include "platform/event.h"
#include "platform/window.h"

namespace knead::studio {

class Gui {
 public:
  // `interface_scale` as in Preferences.
  Gui(Window& window, double interface_scale);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  // Between these two the panels are made.
  void begin_frame();
  // Draws them over the picture.
  void end_frame();

  // After begin_frame: the events that are not for a panel. What is pressed outside of the panels is let go there too.
  std::vector<Event> for_the_view(std::vector<Event> events);

  // Whether the pointer is on a panel.
  bool has_pointer() const;

  // A ball of the material, as high as a line of text, at the cursor.
  void draw_ball(render::Matcap matcap) const;

  // Pixels for one point of the design; texts are 15 points high.
  float unit() const { return unit_; }

 private:
  bool is_for_the_view(const Event& event);

  Window& window_;
  float unit_ = 1;
  std::array<int, render::kMatcapCount> balls_{};  // in the font's texture
  std::vector<MouseButton> buttons_;               // held since they were pressed outside of the panels
  std::vector<std::string> keys_;
};

}  // namespace knead::studio
