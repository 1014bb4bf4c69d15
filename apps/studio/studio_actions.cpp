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

render::Matcap next_matcap(render::Matcap matcap) {
  return render::all_matcaps()[(static_cast<std::size_t>(matcap) + 1) % render::kMatcapCount];
}

// After a colour comes the first.
std::string next_background(const std::string& background) {
  if (background == "gradient") return "light";
  return background == "light" ? "dark" : "gradient";
}

}  // namespace

void Studio::press_key(const KeyChanged& key) {
  if (!key.down || type(key)) return;
  const std::optional<Action> action = action_of(preferences_.keys, {key.key, key.modifiers});
  if (action) perform(*action);
}

void Studio::choose(const StudioTool& tool) {
  if (gesture_) end(false);
  if (masking_) end_masking(false);
  settings_.tool = &tool;
  if (tool.use == ToolUse::stamp && !placed_.stamp) use_stamp(ShapeKind::sphere);
  find_limit_cylinder(false);
}

void Studio::perform(Action action) {
  refresh();
  if (perform_view(action) || perform_tool(action) || perform_mask(action)) return;
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
      if (view_.help) {
        view_.help = false;
      } else if (adjusting_) {
        stop_adjusting(false);
      } else if (gesture_) {
        end(false);
      } else if (layer_drag_) {
        end_handle_drag(false);
      } else if (turntable_) {
        stop_turntable();
      } else if (masking_) {
        end_masking(false);
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
    case Action::inner_ratio:
      begin_adjusting(action);
      return true;
    case Action::larger:
      fix_radius();
      settings_.radius *= kKeyFactor;
      return true;
    case Action::smaller:
      fix_radius();
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
    case Action::remesh_last:
      remesh_last();
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
    case Action::stretch:
      view_.stretch = static_cast<StretchView>((static_cast<int>(view_.stretch) + 1) % 3);
      return true;
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
      view_.look.material = static_cast<render::Material>((static_cast<int>(view_.look.material) + 1) % 3);
      return true;
    case Action::next_matcap:
      if (view_.look.material == render::Material::matcap) view_.look.matcap = next_matcap(view_.look.matcap);
      view_.look.material = render::Material::matcap;
      return true;
    case Action::cavity:
      return toggle(view_.look.relief.cavity);
    case Action::occlusion:
      return toggle(view_.look.relief.occlusion);
    case Action::references:
      return toggle(view_.references);
    case Action::background:
      view_.look.background = next_background(view_.look.background);
      return true;
    default:
      return false;
  }
}

}  // namespace knead::studio
