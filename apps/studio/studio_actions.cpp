// What keys and menus ask for, and numbers that are typed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

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

// --- numbers of a gesture: typed, snapped, or set with the pointer ---------------------------------------------------

namespace {

constexpr double kSnapParts = 100;  // of the diagonal
constexpr double kRatioPerPixel = 0.003;
constexpr double kSnapRatio = 0.05;
constexpr double kMinRatio = 0.01;
constexpr double kMaxRatio = 0.95;
constexpr double kMinRadius = 1e-4;  // of the diagonal
constexpr std::size_t kMaxTyped = 16;

// The character that a key writes into a number, or 0. A comma is a decimal point.
char written_by(std::string_view key) {
  if (key.starts_with("Numpad ")) key.remove_prefix(7);
  if (key == ",") return '.';
  const bool writes = key.size() == 1 && ((key[0] >= '0' && key[0] <= '9') || key[0] == '.' || key[0] == '-');
  return writes ? key[0] : '\0';
}

std::optional<double> number_in(const std::string& text) {
  const bool has_digit = std::any_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  return has_digit ? std::optional(std::strtod(text.c_str(), nullptr)) : std::nullopt;
}

// A minus changes the sign, wherever it is typed.
void write(std::string& text, char c) {
  if (c == '-') {
    text.starts_with('-') ? text.erase(0, 1) : text.insert(0, 1, '-');
  } else if (text.size() < kMaxTyped && (c != '.' || text.find('.') == std::string::npos)) {
    text += c;
  }
}

}  // namespace

double snap_length(double diagonal) {
  const double step = diagonal / kSnapParts;
  const double power = std::pow(10, std::floor(std::log10(step)));
  double best = power;
  for (const double factor : {2.0, 5.0, 10.0}) {
    if (std::abs(std::log(factor * power / step)) < std::abs(std::log(best / step))) best = factor * power;
  }
  return best;
}

std::optional<Amount> Studio::amount() const {
  if (gesture_) return amount_of(*gesture_, settings_);
  if (!adjusting_) return std::nullopt;
  if (adjusting_->what == Action::radius) return Amount{AmountKind::length, settings_.radius};
  return Amount{AmountKind::percent, 100 * settings_.inner_ratio};
}

void Studio::clear_typed() {
  typed_.clear();
  pointer_.typed.reset();
}

// Digits, ".", "," and "-" write the number of the gesture; Backspace takes the last one away.
bool Studio::type(const KeyChanged& key) {
  if (!(key.modifiers == Modifiers{}) || !amount()) return false;
  const char c = written_by(key.key);
  if (c != '\0') {
    write(typed_, c);
  } else if (key.key == "Backspace" && !typed_.empty()) {
    typed_.pop_back();
  } else {
    return false;
  }
  follow_typed();
  return true;
}

void Studio::follow_typed() {
  pointer_.typed = number_in(typed_);
  if (adjusting_) adjust();
  if (!gesture_) return;
  move_gesture(pointer_, gesture_context(), placed_, *gesture_);
  send_live();
}

void Studio::begin_adjusting(Action what) {
  if (gesture_) return;
  clear_typed();
  const bool was_auto = settings_.auto_radius;
  if (what == Action::radius) fix_radius();
  const double value = what == Action::radius ? settings_.radius : settings_.inner_ratio;
  adjusting_ = Adjusting{what, pointer_.x, value, was_auto};
}

void Studio::adjust() {
  const double pixels = pointer_.x - adjusting_->start_x;
  if (adjusting_->what == Action::radius) {
    const double per_pixel = pixel_size(screen(), navigation_.view.target);
    const double pointed =
        snapped(adjusting_->start_value + pixels * per_pixel, snap_length(shown_.diagonal), pointer_);
    settings_.radius = std::max(pointer_.typed.value_or(pointed), kMinRadius * shown_.diagonal);
  } else {
    const double pointed = snapped(adjusting_->start_value + pixels * kRatioPerPixel, kSnapRatio, pointer_);
    const double ratio = pointer_.typed ? *pointer_.typed / 100 : pointed;
    settings_.inner_ratio = std::clamp(ratio, kMinRatio, kMaxRatio);
  }
}

void Studio::stop_adjusting(bool is_kept) {
  if (!is_kept) {
    (adjusting_->what == Action::radius ? settings_.radius : settings_.inner_ratio) = adjusting_->start_value;
    settings_.auto_radius = adjusting_->was_auto;
  }
  adjusting_.reset();
  clear_typed();
}

}  // namespace knead::studio
