#include "panels/interface.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>
#include <variant>

namespace knead::studio {

namespace {

bool may_repeat(Action action) {
  switch (action) {
    case Action::undo:
    case Action::redo:
    case Action::larger:
    case Action::smaller:
    case Action::rounder:
    case Action::sharper:
      return true;
    default:
      return false;
  }
}

// Events that Studio needs even while a dialog is open: the window's size, and the end of what began before.
bool passes_dialogs(const Event& event) {
  const auto* button = std::get_if<ButtonChanged>(&event);
  const auto* key = std::get_if<KeyChanged>(&event);
  return std::holds_alternative<Resized>(event) || (button != nullptr && !button->down) ||
         (key != nullptr && !key->down);
}

bool is_escape(const Event& event) {
  const auto* key = std::get_if<KeyChanged>(&event);
  return key != nullptr && key->down && key->key == "Escape";
}

}  // namespace

Interface::Interface(Studio& studio, Gui& gui, InterfaceHost host)
    : studio_(studio), gui_(gui), host_(std::move(host)) {
  dialogs_.is_recovery_open = !studio_.abandoned().empty();
}

void Interface::set_size(int width, int height) {
  width_ = std::max(width, 1);
  height_ = std::max(height, 1);
  arrange();
  studio_.handle(Resized{width, height});
}

void Interface::arrange() {
  LayoutQuery query;
  query.width = static_cast<float>(width_);
  query.height = static_cast<float>(height_);
  query.unit = gui_.unit();
  query.bar = gui_.bar_height();
  query.item = kToolSize * gui_.unit();
  query.item_gap = kToolGap * gui_.unit();
  query.tools = static_cast<int>(
      std::count_if(studio_tools().begin(), studio_tools().end(), [](const StudioTool& tool) { return tool.in_bar; }));
  query.panels = studio_.view().panels;
  query.labels = studio_.view().tool_labels;
  query.panel_width = static_cast<float>(studio_.preferences().panels.width);
  layout_ = layout_of(query);
  studio_.navigation().covered = margins_of(layout_, query.width, query.height);
}

void Interface::handle(const std::vector<Event>& events) {
  arrange();
  studio_.set_pointer_over_view(!gui_.has_pointer());
  for (const Event& event : gui_.for_the_view(events)) {
    if (const auto* size = std::get_if<Resized>(&event)) {
      set_size(size->width, size->height);
    } else if (!is_asking() && is_escape(event) && gui_.close_lists()) {
      continue;
    } else if (!is_asking() || passes_dialogs(event)) {
      send(event);
    }
    answer();
  }
}

void Interface::send(const Event& event) {
  try {
    if (const auto* files = std::get_if<FilesDropped>(&event)) {
      do_or_ask(studio_, dialogs_, [this, dropped = *files] { studio_.handle(dropped); });
    } else if (!is_idle_repeat(event)) {
      studio_.handle(event);
    }
  } catch (const std::exception& error) {
    studio_.tell({true, error.what()});
  }
}

// A held key keeps sending events; most actions are meant once.
bool Interface::is_idle_repeat(const Event& event) {
  const auto* key = std::get_if<KeyChanged>(&event);
  if (key == nullptr) return false;
  if (!key->down) return held_.erase(key->key) == 0;
  const bool is_first = held_.insert(key->key).second;
  if (is_first) return false;
  const std::optional<Action> action = action_of(studio_.preferences().keys, {key->key, key->modifiers});
  return !action || !may_repeat(*action);
}

void Interface::answer() {
  const auto action = studio_.take_request();
  if (!action) return;
  if (*action == Action::full_screen) {
    if (host_.toggle_full_screen) host_.toggle_full_screen();
  } else if (*action == Action::quit) {
    close();
  } else {
    answer_request(studio_, dialogs_, *action);
  }
}

void Interface::close() {
  do_or_ask(studio_, dialogs_, [this] { has_ended_ = true; });
}

void Interface::draw(const FrameTimes& times, const Stretched& stretched) {
  arrange();
  draw_numbers(studio_, gui_, layout_);
  gui_.set_menu_open(draw_menus(studio_, dialogs_));
  draw_status(studio_, gui_);
  if (studio_.view().panels) {
    draw_tool_bar(studio_, gui_, layout_);
    draw_side_panel(studio_, gui_, layout_, side_panel_);
  }
  if (studio_.view().statistics) draw_statistics(studio_, gui_, layout_, times);
  if (studio_.view().help) draw_help(studio_, gui_);
  const float offer = draw_stretch(studio_, gui_, stretched);
  draw_messages(studio_, gui_, layout_, offer, messages_);
  draw_dialogs(studio_, dialogs_, gui_, host_.write_picture);
  answer();
  if (!gui_.is_dragging()) studio_.remember_panels();
}

}  // namespace knead::studio
