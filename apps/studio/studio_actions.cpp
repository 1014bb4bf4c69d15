// What keys and menus ask for.
#include <algorithm>
#include <array>

#include "studio.h"

namespace knead::studio {

namespace {

constexpr double kKeyFactor = 1.15;  // of [ and ]
constexpr double kKeyRatio = 0.05;

std::optional<StandardView> side_of(Action action) {
  constexpr std::array<std::pair<Action, StandardView>, 6> sides{{{Action::view_front, StandardView::front},
                                                                  {Action::view_back, StandardView::back},
                                                                  {Action::view_right, StandardView::right},
                                                                  {Action::view_left, StandardView::left},
                                                                  {Action::view_top, StandardView::top},
                                                                  {Action::view_bottom, StandardView::bottom}}};
  for (const auto& [wanted, side] : sides) {
    if (wanted == action) return side;
  }
  return std::nullopt;
}

}  // namespace

void Studio::press_key(const KeyChanged& key) {
  if (!key.down || type(key)) return;
  const std::optional<Action> action = action_of(preferences_.keys, {key.key, key.modifiers});
  if (action) perform(*action);
}

void Studio::choose(const StudioTool& tool) {
  if (gesture_) end(false);
  settings_.tool = &tool;
  if (tool.use == ToolUse::stamp && !placed_.stamp) use_stamp(ShapeKind::sphere);
  find_barrel(false);
}

void Studio::perform(Action action) {
  refresh();
  if (perform_view(action) || perform_tool(action)) return;
  switch (action) {
    case Action::undo:
      return undo();
    case Action::redo:
      return redo();
    case Action::save:
      if (shown_.opened == 0) return;
      if (shown_.session_path.empty()) {
        request_ = Action::save_as;
      } else {
        save(shown_.session_path);
      }
      return;
    case Action::cancel:
      if (adjusting_) {
        stop_adjusting(false);
      } else if (gesture_) {
        end(false);
      } else if (worker_->is_busy()) {
        worker_->cancel();
      } else if (shown_.looked_at) {
        look_at(std::nullopt);
      } else {
        clear_placed();
      }
      return;
    case Action::finish:
      if (gesture_) accept();
      if (adjusting_) stop_adjusting(true);
      return;
    default:
      request_ = action;
  }
}

bool Studio::perform_tool(Action action) {
  if (const StudioTool* tool = tool_of(action)) {
    choose(*tool);
    return true;
  }
  switch (action) {
    case Action::radius:
      begin_adjusting(action, settings_.radius);
      return true;
    case Action::inner_ratio:
      begin_adjusting(action, settings_.inner_ratio);
      return true;
    case Action::larger:
      settings_.radius *= kKeyFactor;
      return true;
    case Action::smaller:
      settings_.radius /= kKeyFactor;
      return true;
    case Action::rounder:
      settings_.inner_ratio = std::max(settings_.inner_ratio - kKeyRatio, 0.01);
      return true;
    case Action::sharper:
      settings_.inner_ratio = std::min(settings_.inner_ratio + kKeyRatio, 0.95);
      return true;
    case Action::drag_mode:
      settings_.drag = static_cast<DragMode>((static_cast<int>(settings_.drag) + 1) % 4);
      return true;
    case Action::paint_in:
      settings_.paint_in = !settings_.paint_in;
      return true;
    case Action::mirror_x:
    case Action::mirror_y:
    case Action::mirror_z: {
      bool& mirror = settings_.mirror[static_cast<std::size_t>(action) - static_cast<std::size_t>(Action::mirror_x)];
      mirror = !mirror;
      return true;
    }
    case Action::remesh:
      settings_.remesh = !settings_.remesh;
      return true;
    default:
      return false;
  }
}

bool Studio::perform_view(Action action) {
  if (const auto side = side_of(action)) {
    const View& before = navigation_.view;
    navigation_.view = keeping(navigation_.home.value_or(before.target), before, seen_from(before, *side));
    return true;
  }
  const auto toggle = [](bool& flag) {
    flag = !flag;
    return true;
  };
  switch (action) {
    case Action::frame_all:
      frame_all();
      return true;
    case Action::frame_stroke:
      frame_stroke();
      return true;
    case Action::projection:
      navigation_.view = toggled_projection(navigation_.view);
      return true;
    case Action::wireframe:
      return toggle(view_.wireframe);
    case Action::influence:
      return toggle(view_.influence);
    case Action::region:
      return toggle(view_.region);
    case Action::cutting_plane:
      return toggle(view_.cut);
    case Action::help:
      return toggle(view_.help);
    case Action::panels:
      return toggle(view_.panels);
    case Action::history:
      return toggle(view_.history);
    case Action::statistics:
      return toggle(view_.statistics);
    case Action::tool_labels:
      return toggle(view_.tool_labels);
    case Action::shading:
      view_.material = static_cast<render::Material>((static_cast<int>(view_.material) + 1) % 3);
      return true;
    default:
      return false;
  }
}

}  // namespace knead::studio
