// Pins: clicked, changed by their list, and carried along with the shape.
#include <algorithm>
#include <utility>

#include "gestures/gesture_kinds.h"
#include "gestures/parts.h"
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
  std::optional<std::size_t> pin = pin_at(pointer_, surroundings(), placed_.pins);
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
  const std::optional<std::size_t> part = part_at(pointer_, surroundings(), placed_.parts);
  if (part) remove_part(*part);
  return part.has_value();
}

// The drag that may follow turns the limb about its joint, also where its gizmo is.
bool Studio::propose_limb(const ButtonChanged& button) {
  if (!hit_at(pointer_, surroundings())) return false;
  withdraw(Subject::gesture);
  const std::string problem = add_limb(pointer_, surroundings(), placed_);
  if (!problem.empty()) {
    tell({true, problem, Subject::gesture});
    return true;
  }
  press({button.button, true, button.x, button.y, button.modifiers});
  auto* const part = gesture_ ? std::get_if<PartGesture>(&gesture_->kind) : nullptr;
  if (part != nullptr) part->handle.reset();
  return true;
}

void Studio::hold_part(std::size_t part, bool holds) { placed_.parts.holds[part] = holds; }

void Studio::stiffen_part(std::size_t part, double stiffness) { placed_.parts.stiffness[part] = stiffness; }

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
  return pin_at(pointer_, surroundings(), placed_.pins);
}

}  // namespace knead::studio
