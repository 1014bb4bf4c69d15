// What lies between a window and Studio: decides which events are for a panel, a dialog or the shape, and makes the
// panels. Needs no window, so that tests can drive it by events.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "panels/file_dialog.h"
#include "panels/panels.h"
#include "platform/gui.h"
#include "platform/window.h"
#include "studio.h"

namespace knead::studio {

// --- dialogs, and the menus that open them ---------------------------------------------------------

// The search of commands.
struct CommandSearch {
  bool is_open = false;
  std::string text;
  std::size_t chosen = 0;  // of those found
};

// The sheet that Studio begins with, and the tour.
struct Welcome {
  bool is_open = false;
  std::optional<std::size_t> tour;  // the step that is shown, from 0
  std::size_t entries = 0;          // of the history when the tour began
  float card_height = 0;            // of the tour, as last drawn
};

struct Dialogs {
  CommandSearch search;
  Welcome welcome;
  FileDialog file;
  FrameExport motion;  // the motion that was shown last
  int frame = 0;       // its shown frame, from 1; 0: the present shape

  bool is_new_shape_open = false;
  ShapeKind new_kind = ShapeKind::sphere;
  int new_vertices = 40'000;

  bool is_recovery_open = false;
  std::optional<std::filesystem::path> to_discard;  // the next click discards this journal

  // An action that would discard unsaved work, until the user has decided.
  std::function<void()> pending;
  bool is_saving = false;  // the work is saved first
};

// Returns whether a dialog is open, which then gets all keys and clicks.
inline bool is_asking(const Dialogs& dialogs) {
  return dialogs.file.is_open || dialogs.is_new_shape_open || dialogs.is_recovery_open || dialogs.search.is_open ||
         dialogs.welcome.is_open || dialogs.pending != nullptr;
}

// Performs an action that discards unsaved work; asks first if there is any.
void do_or_ask(Studio& studio, Dialogs& dialogs, std::function<void()> what);

// Performs a request of Studio; returns false for actions of the window itself (quit, full_screen).
bool answer_request(Studio& studio, Dialogs& dialogs, Action action);

// Returns the place of an action in the menus or panels, in a few words.
std::string place_of(Action action);

// Returns whether a menu is open.
bool draw_menus(Studio& studio, Dialogs& dialogs);

void draw_search(Studio& studio, const Gui& gui, CommandSearch& search);

// Draws the welcome sheet: a sphere, a file, one of three examples, or the tour. It closes with a choice, Escape or a
// click beside it.
void draw_welcome(Studio& studio, Dialogs& dialogs, const Gui& gui);

// Draws a step of the tour beside its subject. The user can work meanwhile.
void draw_tour(Studio& studio, Welcome& welcome, const Gui& gui, const Layout& layout);

// Draws the open dialogs. `picture` writes the view to a file.
void draw_dialogs(Studio& studio, Dialogs& dialogs, const Gui& gui,
                  const std::function<void(const std::filesystem::path&)>& picture);

// --- the interface
// ----------------------------------------------------------------------------------------------------

// The functions of the window that the interface calls.
struct InterfaceHost {
  std::function<void()> toggle_full_screen{};
  std::function<void(const std::filesystem::path&)> write_picture{};
};

class Interface {
 public:
  // Offers unsaved work, if there is some.
  Interface(Studio& studio, Gui& gui, InterfaceHost host);

  // Gives Studio the size of the window and the parts that panels cover. Called for every Resized; the window calls it
  // before the first frame.
  void set_size(int width, int height);

  // Passes on the events that are not for a panel. Call it after Gui::begin_frame.
  void handle(const std::vector<Event>& events);

  // Draws all panels and dialogs.
  void draw(const FrameTimes& times, const Stretched& stretched);

  // Opens the welcome sheet, unless there is unsaved work to recover or the preferences disable it.
  void welcome();

  // Closes the window, and asks first if there is unsaved work; has_ended() is true afterwards.
  void close();
  bool has_ended() const { return has_ended_; }

  // Returns whether a message is shown, which may fade without an event.
  bool has_messages() const { return !messages_.messages.empty(); }

  // Returns whether a dialog is open.
  bool is_asking() const { return studio::is_asking(dialogs_); }

  const Messages& messages() const { return messages_; }
  const Layout& layout() const { return layout_; }

 private:
  void arrange();
  Vec3d middle_of_free() const;
  void show_in_middle(const Vec3d& point);
  void send(const Event& given);
  void note_right_click(const Event& event, bool was_free);
  bool is_idle_repeat(const Event& event);
  bool send_to_target(const Event& event);
  void answer();

  Studio& studio_;
  Gui& gui_;
  InterfaceHost host_;
  Dialogs dialogs_;
  SidePanel side_panel_;
  Messages messages_;
  CompactBar compact_;
  Layout layout_;
  std::optional<Pixel> right_press_;   // where the right button was pressed; its release may be a click
  std::optional<Pixel> pointer_menu_;  // the place of the menu to open in this frame
  int width_ = 1;
  int height_ = 1;
  std::set<std::string> held_;
  bool is_over_target_ = false;  // the pointer
  bool has_ended_ = false;
};

}  // namespace knead::studio
