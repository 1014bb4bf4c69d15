// What keys and menus ask for, and numbers that are typed.
#include <algorithm>
#include <cstdlib>

#include "studio.h"

namespace knead::studio {

void Studio::press_key(const KeyChanged& key) {
  if (!key.down || type(key)) return;
  const std::optional<Action> action = action_of(preferences().keys, {key.key, key.modifiers});
  if (action) perform(*action);
}

void Studio::choose(const StudioTool& tool) {
  if (gesture_) end(false);
  if (masks_.is_drawing()) masks_.end(false);
  choose_tool(tool, tools_.settings());
  if (tool.use == ToolUse::stamp && !tools_.placed().stamp) tools_.use_stamp(ShapeKind::sphere);
  tools_.find_limit_cylinder(false);
}

void Studio::perform(Action action) {
  refresh();
  if (action == Action::frame_stroke) return view_.frame_stroke(tools_.placed_box());
  if (view_.perform(action) || tools_.perform(action) || perform_mask(action)) return;
  if (const StudioTool* tool = tool_of(action)) return choose(*tool);
  switch (action) {
    case Action::undo:
      return undo();
    case Action::redo:
      return redo();
    case Action::save:
      return save();
    case Action::cancel:
      return cancel();
    case Action::finish:
      if (gesture_) accept();
      if (adjusting_) stop_adjusting(true);
      return;
    case Action::radius:
    case Action::inner_ratio:
      return begin_adjusting(action);
    case Action::remesh_last:
      return change_last([this](SessionStroke& stroke) { stroke.remesh = settings().remesh_settings; });
    default:
      request_ = action;
  }
}

void Studio::save() {
  if (shown().opened == 0) return;
  if (shown().session_path.empty()) {
    request_ = Action::save_as;
  } else {
    document_.save(shown().session_path);
  }
}

// Gives up one thing: the first that there is.
void Studio::cancel() {
  if (view_.settings().help) {
    view_.settings().help = false;
  } else if (adjusting_) {
    stop_adjusting(false);
  } else if (gesture_) {
    end(false);
  } else if (history_.is_dragging()) {
    end_handle_drag(false);
  } else if (view_.turntable()) {
    view_.stop_turntable();
  } else if (masks_.is_drawing()) {
    masks_.end(false);
  } else if (document_.worker().is_busy()) {
    document_.worker().cancel();
  } else if (shown().looked_at) {
    history_.look_at(std::nullopt);
  } else {
    tools_.clear_placed();
  }
}

const char* Studio::cancellable() const {
  constexpr double kLongWork = 1.5;  // seconds
  const std::optional<WorkStatus> work = document_.worker().status();
  if (view_.turntable() || (work && work->seconds > kLongWork)) return "Stop";
  if (shown().looked_at) return "Back to the present";
  const PlacedTools& placed = tools_.placed();
  const ToolUse use = settings().tool->use;
  if (use == ToolUse::pose && placed.parts.selected) {
    return settings().pose == PoseMode::brush ? "Next part" : "Deselect the part";
  }
  const bool has_points = !placed.points.empty() || !placed.curves.empty();
  const bool has_gizmo = placed.placement && (use == ToolUse::turn || use == ToolUse::stamp);
  if (has_gizmo) return "Remove the gizmo";
  return has_points && (use == ToolUse::points || use == ToolUse::curve) ? "Remove the points" : nullptr;
}

void Studio::change_mask(MaskEdit edit) {
  refresh();
  if (!gesture_) masks_.change(edit);
}

bool Studio::perform_mask(Action action) {
  if (action >= Action::hide_masked && action <= Action::show_all) {
    interrupt();
    document_.post([action, mask = masks_.values()](Document& document, Progress& /*progress*/) {
      if (action == Action::show_all) return document.show_all_faces();
      document.hide_faces(mask, action == Action::hide_masked);
    });
    return true;
  }
  if (action < Action::mask_fill || action > Action::mask_shrink) return false;
  change_mask(static_cast<MaskEdit>(static_cast<int>(action) - static_cast<int>(Action::mask_fill)));
  return true;
}

// --- numbers of a gesture: typed, snapped, or set with the pointer ---------------------------------------------------

namespace {

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

std::optional<Amount> Studio::amount() const {
  if (gesture_) return amount_of(*gesture_, settings());
  if (!adjusting_) return std::nullopt;
  if (adjusting_->what == Action::radius) return Amount{AmountKind::length, settings().radius};
  return Amount{AmountKind::percent, 100 * settings().inner_ratio};
}

std::optional<PointedNumber> Studio::number() const {
  const std::optional<Amount> now = amount();
  return now ? std::optional(PointedNumber{*now, typed_, adjusting_.has_value()}) : std::nullopt;
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
  move_gesture(pointer_, gesture_context(), tools_.placed(), *gesture_);
  send_live();
}

void Studio::begin_adjusting(Action what) {
  if (gesture_) return;
  clear_typed();
  const bool was_auto = settings().auto_radius;
  if (what == Action::radius) tools_.fix_radius();
  const double value = what == Action::radius ? settings().radius : settings().inner_ratio;
  adjusting_ = Adjusting{what, pointer_.x, value, was_auto};
}

void Studio::adjust() {
  const double pixels = pointer_.x - adjusting_->start_x;
  if (adjusting_->what == Action::radius) {
    const double per_pixel = pixel_size(view_.screen(), view_.navigation().view.target);
    const double pointed =
        snapped(adjusting_->start_value + pixels * per_pixel, snap_length(shown().diagonal), pointer_);
    tools_.settings().radius = std::max(pointer_.typed.value_or(pointed), kMinRadius * shown().diagonal);
  } else {
    const double pointed = snapped(adjusting_->start_value + pixels * kRatioPerPixel, kSnapRatio, pointer_);
    const double ratio = pointer_.typed ? *pointer_.typed / 100 : pointed;
    tools_.settings().inner_ratio = std::clamp(ratio, kMinRatio, kMaxRatio);
  }
}

void Studio::stop_adjusting(bool is_kept) {
  if (!is_kept) {
    (adjusting_->what == Action::radius ? tools_.settings().radius : tools_.settings().inner_ratio) =
        adjusting_->start_value;
    tools_.settings().auto_radius = adjusting_->was_auto;
  }
  adjusting_.reset();
  clear_typed();
}

}  // namespace knead::studio
