// Dear ImGui as Studio uses it: how it looks, and which events are for a panel. Needs no window (window.h).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "knead/editor/render.h"
#include "platform/window.h"

namespace knead::studio {

// How dark the window is behind a dialog, from 0 to 1.
inline constexpr float kDimmed = 0.45F;

class Gui {
 public:
  // unit: pixels for one point of the design; texts are 15 points high.
  explicit Gui(double unit);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  // Between these two the panels are made. The events are those of this frame (take_frame).
  void begin_frame(const std::vector<Event>& events);
  void end_frame();

  // After begin_frame: the events that are not for a panel. What is pressed outside of the panels is let go there too.
  std::vector<Event> for_the_view(std::vector<Event> events);

  // Whether the pointer is on a panel, or nowhere in the window.
  bool has_pointer() const;

  // Whether a panel is being changed with the pointer.
  bool is_dragging() const;

  // Closes open lists and menus. Returns whether there were any. Not to be called while a dialog is open.
  bool close_lists();

  // Says whether a menu is open: then a click beside it only closes it, while a click beside an open list also acts.
  void set_menu_open(bool is_open) { is_menu_open_ = is_open; }

  // A ball of the material, as high as a line of text, at the cursor.
  void draw_ball(render::Matcap matcap) const;

  // Texts between these two are headings, 20 points high.
  static void begin_heading();
  static void end_heading();

  // Pixels for one point of the design; texts are 15 points high.
  float unit() const { return unit_; }

  // Height of the menu bar, in pixels; known before the first frame.
  float bar_height() const;

 private:
  bool is_for_the_view(const Event& event);

  float unit_ = 1;
  bool is_menu_open_ = false;
  std::array<int, render::kMatcapCount> balls_{};  // in the font's texture
  std::array<bool, 3> down_{};                     // Dear ImGui's buttons
  std::vector<MouseButton> buttons_;               // held since they were pressed outside of the panels
  std::vector<std::string> keys_;
};

// Takes away as many events, from the first on, as one frame may get. Dear ImGui 1.86 looks at the pointer once a
// frame: what is pressed or let go must be seen where that happens, however late the frame is.
std::vector<Event> take_frame(std::vector<Event>& events);

// What was typed, in its order: a key that went down (its repeats, too) or up, or the text that the key before it
// wrote.
struct Typed {
  enum class What { down, up, text };
  What what = What::text;
  int key = 0;
  bool is_shift = false;
};

// Returns how many of these, from the first on, one frame may get; at least 1 unless there are none. Dear ImGui 1.86
// looks at the keys once a frame, and reads text before keys. So a key that goes down and up needs two frames.
std::size_t typed_in_a_frame(std::span<const Typed> typed);

// Where Studio cannot read the computer's files, as on a page: the person brings files, and the page downloads what
// Studio writes.

// Returns whether files must be brought.
bool must_bring_files();

// Lets the person choose files of the computer. They come as FilesDropped.
void choose_files_to_bring();

}  // namespace knead::studio
