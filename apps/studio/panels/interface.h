// What lies between a window and Studio: decides which events are for a panel, a dialog or the shape, and makes the
// panels. Needs no window, so that tests can drive it by events.
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "panels/dialogs.h"
#include "panels/panels.h"
#include "platform/event.h"
#include "platform/gui.h"
#include "studio.h"

namespace knead::studio {

// What the interface asks of its window.
struct InterfaceHost {
  std::function<void()> toggle_full_screen{};
  std::function<void(const std::filesystem::path&)> write_picture{};
};

class Interface {
 public:
  // Offers unsaved work, if there is some.
  Interface(Studio& studio, Gui& gui, InterfaceHost host);

  // Tells Studio how large the window is and what the panels cover of it. Called for every Resized; the window calls it
  // before the first frame.
  void set_size(int width, int height);

  // After Gui::begin_frame: hands on the events that are for the shape.
  void handle(const std::vector<Event>& events);

  // Makes all panels and dialogs.
  void draw(const FrameTimes& times, const Stretched& stretched);

  // The person wants to close the window. Asks first if there is unsaved work; then has_ended().
  void close();
  bool has_ended() const { return has_ended_; }

  // Whether a message is shown, which may fade without an event.
  bool has_messages() const { return !messages_.messages.empty(); }

  // Returns whether a dialog is open.
  bool is_asking() const { return studio::is_asking(dialogs_); }

  const Messages& messages() const { return messages_; }
  const Layout& layout() const { return layout_; }

 private:
  void arrange();
  void send(const Event& event);
  bool is_idle_repeat(const Event& event);
  void answer();

  Studio& studio_;
  Gui& gui_;
  InterfaceHost host_;
  Dialogs dialogs_;
  SidePanel side_panel_;
  Messages messages_;
  Layout layout_;
  int width_ = 1;
  int height_ = 1;
  std::set<std::string> held_;
  bool has_ended_ = false;
};

}  // namespace knead::studio
