// Dear ImGui as Studio uses it: its style, and the events for panels. Needs no window (window.h).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "knead/editor/render.h"
#include "platform/window.h"

namespace knead::studio {

// The darkness of the window behind a dialog, from 0 to 1.
inline constexpr float kDimmed = 0.45F;

class Gui {
 public:
  // unit: pixels for one point of the design; texts are 15 points high.
  explicit Gui(double unit);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  // Draw the panels between these two calls. `events`: those of this frame (take_frame).
  void begin_frame(const std::vector<Event>& events);
  void end_frame();

  // Returns the events that are not for a panel; call it after begin_frame(). The release of a button or key that was
  // pressed outside of the panels is never for a panel.
  std::vector<Event> for_the_view(std::vector<Event> events);

  // Returns whether the pointer is on a panel, or outside of the window.
  bool has_pointer() const;

  // Returns whether the pointer is dragging something in a panel.
  bool is_dragging() const;

  // Closes open lists and menus. Returns whether there were any. Not to be called while a dialog is open.
  bool close_lists();

  // Says whether a menu is open: then a click beside it only closes it, while a click beside an open list also acts.
  void set_menu_open(bool is_open) { is_menu_open_ = is_open; }

  // Draws a ball of the material, as high as a line of text, at the cursor of Dear ImGui.
  void draw_ball(render::Matcap matcap) const;

  // Texts between these two are headings, 20 points high.
  static void begin_heading();
  static void end_heading();

  // Pixels for one point of the design; texts are 15 points high.
  float unit() const { return unit_; }

  // Says whether fingers press, for which rows and buttons are higher.
  void set_touch(bool is_touch);
  bool is_touch() const { return is_touch_; }

  // Scrolls the panel at a place by so many pixels, as a finger drags it. Returns whether it scrolls.
  static bool scroll(double x, double y, double by);

  // Height of the menu bar, in pixels; known before the first frame.
  float bar_height() const;

 private:
  bool is_for_the_view(const Event& event);

  float unit_ = 1;
  bool is_touch_ = false;
  bool is_menu_open_ = false;
  std::array<int, render::kMatcapCount> balls_{};  // in the font's texture
  std::array<bool, 3> down_{};                     // Dear ImGui's buttons
  std::vector<MouseButton> buttons_;               // held since they were pressed outside of the panels
  std::vector<std::string> keys_;
};

// Removes and returns the first events, as many as one frame may get. Dear ImGui 1.86 reads the pointer once a frame,
// so a frame ends with each press or release, and sees it at its place.
std::vector<Event> take_frame(std::vector<Event>& events);

// A typed event: a key that went down (also a repeat) or up, or the text that the key before it wrote.
struct Typed {
  enum class What { down, up, text };
  What what = What::text;
  int key = 0;
  bool is_shift = false;
};

// Returns how many of these, from the first on, one frame may get; at least 1 unless there are none. Dear ImGui 1.86
// looks at the keys once a frame, and reads text before keys. So a key that goes down and up needs two frames.
std::size_t typed_in_a_frame(std::span<const Typed> typed);

// On a page Studio cannot read the computer's files: the user brings files, and the page downloads what Studio writes.

// Returns whether files must be brought.
bool must_bring_files();

// Asks the user for files of the computer. They come as FilesDropped.
void choose_files_to_bring();

}  // namespace knead::studio
