// What is marked on the shape: pins and parts, which are clicked, changed by their list, and follow the shape; masks.
#include <algorithm>
#include <utility>

#include "gestures/gesture_kinds.h"
#include "gestures/tools.h"
#include "studio.h"

namespace knead::studio {

double Studio::radius() const {
  const std::vector<Pin>& pins = placed_.pins;
  const bool is_auto = has_exact_pins(settings_) && settings_.auto_radius && !pins.empty();
  if (!is_auto) return settings_.radius;
  return radius_of(pins_stroke(pins, 0, pins.front().place, settings_)).value_or(settings_.radius);
}

void Studio::fix_radius() {
  if (!has_exact_pins(settings_)) return;
  settings_.radius = radius();
  settings_.auto_radius = false;
}

// After a drag the pins are where it took them, before the shape is.
void Studio::refresh_pins() {
  const bool drags_one = gesture_ && (std::holds_alternative<PinsGesture>(gesture_->kind) ||
                                      std::holds_alternative<PartGesture>(gesture_->kind));
  if (drags_one || shown_.looked_at || shown_.ended != ended_) return;
  if (!placed_.pins.empty()) follow(placed_.pins, shown_.state);
  follow(placed_.parts, shown_.state);
}

bool Studio::change_pin(const Event& event) {
  const auto* const button = std::get_if<ButtonChanged>(&event);
  const bool is_meant = button != nullptr && button->down && button->button == MouseButton::left &&
                        (button->modifiers.alt || button->modifiers.shift || button->is_double);
  if (!is_meant || settings_.tool->use != ToolUse::pose || shown_.opened == 0 || shown_.looked_at) return false;
  place_pointer(button->x, button->y, button->modifiers);
  std::optional<std::size_t> pin = pin_at(pointer_, gesture_context(), placed_.pins);
  if (pin && button->is_double && !has_exact_pins(settings_) && pin == set_pin_) {
    remove_pin(*pin);  // by the first of the two clicks
    pin.reset();
  }
  if (!pin) return change_part(*button);
  const Pin& chosen = placed_.pins[*pin];
  if (button->modifiers.alt) {
    remove_pin(*pin);
  } else if (button->modifiers.shift) {
    select_pin(*pin, !chosen.is_selected);
  } else {
    hold_pin(*pin, !chosen.holds);
  }
  return true;
}

// Alt removes a part; a double click proposes the limb there.
bool Studio::change_part(const ButtonChanged& button) {
  if (has_exact_pins(settings_) || button.modifiers.shift) return false;
  if (!button.modifiers.alt) return propose_limb(button);
  const std::optional<std::size_t> part = part_at(pointer_, gesture_context(), placed_.parts);
  if (part) remove_part(*part);
  return part.has_value();
}

// The drag that may follow turns the limb about its joint, also where its gizmo is.
bool Studio::propose_limb(const ButtonChanged& button) {
  if (!hit_at(pointer_, gesture_context())) return false;
  withdraw(Subject::gesture);
  const std::string problem = add_limb(pointer_, gesture_context(), placed_);
  if (!problem.empty()) {
    tell({true, problem, Subject::gesture});
    return true;
  }
  press({button.button, true, button.x, button.y, button.modifiers});
  auto* const part = gesture_ ? std::get_if<PartGesture>(&gesture_->kind) : nullptr;
  if (part != nullptr) part->handle.reset();
  return true;
}

void Studio::select_part(std::optional<std::size_t> part) { studio::select_part(part, placed_.parts); }

void Studio::remove_part(std::size_t part) { studio::remove_part(part, placed_.parts); }

void Studio::set_pins(std::vector<Pin> pins) {
  clear_pins();
  placed_.pins = std::move(pins);
  follow(placed_.pins, shown_.state);
}

void Studio::select_pin(std::size_t pin, bool is_selected) { placed_.pins[pin].is_selected = is_selected; }

void Studio::select_pins(bool are_selected) {
  for (Pin& pin : placed_.pins) pin.is_selected = are_selected;
}

void Studio::hold_pin(std::size_t pin, bool holds) { placed_.pins[pin].holds = holds; }

void Studio::remove_pin(std::size_t pin) {
  placed_.pins.erase(placed_.pins.begin() + static_cast<std::ptrdiff_t>(pin));
  placed_.lit_pin.reset();
  set_pin_.reset();
}

void Studio::move_pin(std::size_t pin, const Vec3d& to) {
  if (gesture_ || masking_ || shown_.looked_at) return;
  SessionStroke stroke;
  if (has_exact_pins(settings_)) {
    stroke.stroke = pins_stroke(placed_.pins, pin, to, settings_);
  } else {
    PinsGesture gesture;
    gesture.drag.start = placed_.pins[pin].place;
    gesture.pins = placed_.pins;
    gesture.parts = placed_.parts;
    gesture.dragged = pin;
    gesture.to = to;
    gesture.rests = true;
    const std::optional<PoseStroke> pose = pose_stroke(gesture, shown_.state, settings_);
    if (!pose) return;
    stroke.stroke = *pose;
  }
  if (settings_.remesh) stroke.remesh = settings_.remesh_settings;
  for (const PinGoal& goal : pin_goals(placed_.pins, pin, to, settings_)) placed_.pins[goal.pin].place = goal.to;
  apply({std::move(stroke)});
}

void Studio::clear_pins() {
  placed_.pins.clear();
  placed_.lit_pin.reset();
}

std::optional<std::size_t> Studio::pointed_pin() const {
  if (settings_.tool->use != ToolUse::pose || shown_.opened == 0 || shown_.looked_at) return std::nullopt;
  if (const auto* const pins = gesture_ ? std::get_if<PinsGesture>(&gesture_->kind) : nullptr) return pins->dragged;
  if (placed_.lit_pin || !pointer_is_over_view_) return placed_.lit_pin;
  return pin_at(pointer_, gesture_context(), placed_.pins);
}

// --- masks: painted, drawn round, and changed as a whole. Each change is a stroke in the history ---------------------

// What the document's mask was when the values were made.
void Studio::refresh_mask() {
  if (shown_.looked_at || masking_) return;
  const bool is_same = shown_.state.mask.shares(values_mask_) && shown_.state.mesh == values_mesh_;
  if (is_same) return;
  values_mask_ = shown_.state.mask;
  values_mesh_ = shown_.state.mesh;
  mask_values_ = studio::mask_values(shown_.history, shown_.state);
}

std::vector<Pixel> Studio::drawn_line() const {
  if (masking_) return masking_->line;
  const auto* const lasso = gesture_ ? std::get_if<LassoGesture>(&gesture_->kind) : nullptr;
  return lasso != nullptr ? lasso->line : std::vector<Pixel>{};
}

void Studio::begin_masking() {
  masking_ = Masking{mask_values_, pointer_.modifiers.ctrl, {{pointer_.x, pointer_.y}}, screen()};
  move_masking();
}

void Studio::move_masking() {
  std::vector<Pixel>& line = masking_->line;
  switch (settings_.mask_mode) {
    case MaskMode::paint:
      return paint_mask();
    case MaskMode::lasso:
      return extend_line(pointer_, line);
    case MaskMode::box: {
      const Pixel first = line.front();
      const Pixel here{pointer_.x, pointer_.y};
      line = {first, {here.x, first.y}, here, {first.x, here.y}};
      return;
    }
  }
}

void Studio::paint_mask() {
  const auto hit = hit_at(pointer_, gesture_context());
  if (!hit) return;
  MaskBrush brush{hit->point, settings_.inner_ratio * settings_.radius, settings_.radius, masking_->erases};
  paint(brush, shown_.state.positions, mask_values_);
  for (const SymmetryImage& image : images_of(settings_)) {
    brush.center = image.motion(hit->point);
    paint(brush, shown_.state.positions, mask_values_);
  }
}

void Studio::end_masking(bool is_kept) {
  const Masking done = std::move(*masking_);
  masking_.reset();
  if (!is_kept) {
    mask_values_ = done.before;
    return;
  }
  if (settings_.mask_mode != MaskMode::paint) {
    fill(done.line, done.screen, done.erases, shown_.state.positions, mask_values_);
  }
  if (mask_values_ != done.before) apply_mask();
}

void Studio::change_mask(MaskEdit edit) {
  refresh();
  if (gesture_ || masking_ || shown_.opened == 0 || shown_.looked_at) return;
  const MaskValues before = mask_values_;
  mask_values_ = changed(std::move(mask_values_), edit, *shown_.state.mesh);
  if (mask_values_ != before) apply_mask();
}

bool Studio::perform_mask(Action action) {
  if (action < Action::mask_fill || action > Action::mask_shrink) return false;
  change_mask(static_cast<MaskEdit>(static_cast<int>(action) - static_cast<int>(Action::mask_fill)));
  return true;
}

void Studio::apply_mask() {
  apply({{mask_stroke(mask_values_, shown_.state, settings_.mask_width * settings_.radius)}});
}

// As a gesture.
void Studio::apply(std::vector<SessionStroke> strokes) {
  if (!pending_) {
    pending_ = PendingStrokes{shown_.state, {}};
    ended_strokes_.clear();
  }
  pending_->strokes = ended_strokes_;
  pending_->strokes.insert(pending_->strokes.end(), strokes.begin(), strokes.end());
  ended_strokes_ = pending_->strokes;
  ++ended_;
  post([this, strokes = std::move(strokes)](Progress& progress) {
    document_.set_live(strokes, progress);
    document_.finish(progress);
  });
}

}  // namespace knead::studio
