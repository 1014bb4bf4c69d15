// Clicks on pins and parts, changes by their list, and their adaptation to the shape.
#include <utility>

#include "gestures/gesture_kinds.h"
#include "gestures/tools.h"
#include "studio.h"

namespace knead::studio {

// After a drag the pins are at their new places before the shape has followed.
void Studio::refresh_pins() {
  const bool drags_one = gesture_ && (std::holds_alternative<PinsGesture>(gesture_->kind) ||
                                      std::holds_alternative<PartGesture>(gesture_->kind));
  if (drags_one || shown().looked_at || shown().ended != ended_) return;
  if (!tools_.placed().pins.empty()) follow(tools_.placed().pins, shown().state);
  follow(tools_.placed().parts, shown().state);
  if (gesture_) return;
  tools_.follow_line();
  tools_.follow_lattice();
}

bool Studio::change_pin(const Event& event) {
  const auto* const button = std::get_if<ButtonChanged>(&event);
  const bool is_meant = button != nullptr && button->down && button->button == MouseButton::left &&
                        (button->modifiers.alt || button->modifiers.shift || button->is_double);
  if (!is_meant || settings().tool->use != ToolUse::pose || shown().opened == 0 || shown().looked_at) return false;
  place_pointer(button->x, button->y, button->modifiers);
  std::optional<std::size_t> pin = pin_at(pointer_, gesture_context(), tools_.placed().pins);
  const std::optional<std::size_t> first = tools_.set_pin();  // by the first of two clicks, on the nearest vertex
  if (button->is_double && !has_exact_pins(settings()) && first && (!pin || pin == first)) {
    tools_.remove_pin(*first);
    pin.reset();
  }
  if (!pin) return change_part(*button);
  Pin& chosen = tools_.placed().pins[*pin];
  if (button->modifiers.alt) {
    tools_.remove_pin(*pin);
  } else if (button->modifiers.shift) {
    chosen.is_selected = !chosen.is_selected;
  } else {
    chosen.holds = !chosen.holds;
  }
  return true;
}

// Alt removes a part; a double click proposes the limb there.
bool Studio::change_part(const ButtonChanged& button) {
  if (has_exact_pins(settings()) || button.modifiers.shift) return false;
  if (!button.modifiers.alt) return propose_limb(button);
  const std::optional<std::size_t> part = part_at(pointer_, gesture_context(), tools_.placed().parts);
  if (part) remove_part(*part, tools_.placed().parts);
  return part.has_value();
}

// The drag that may follow turns the limb about its joint, also where its gizmo is.
bool Studio::propose_limb(const ButtonChanged& button) {
  if (!hit_at(pointer_, gesture_context())) return false;
  document_.withdraw(Subject::gesture);
  const std::string problem = add_limb(pointer_, gesture_context(), tools_.placed());
  if (!problem.empty()) {
    document_.tell({true, problem, Subject::gesture});
    return true;
  }
  const PartMarks& parts = tools_.placed().parts;
  if (part_at(pointer_, gesture_context(), parts) != parts.selected) return true;  // it is where the limb bends
  press({button.button, true, button.x, button.y, button.modifiers});
  auto* const part = gesture_ ? std::get_if<PartGesture>(&gesture_->kind) : nullptr;
  if (part != nullptr) part->handle.reset();
  return true;
}

void Studio::move_pin(std::size_t pin, const Vec3d& to) {
  if (gesture_ || masks_.is_drawing() || shown().looked_at) return;
  PinsGesture gesture;
  gesture.drag.start = tools_.placed().pins[pin].place;
  gesture.pins = tools_.placed().pins;
  gesture.parts = tools_.placed().parts;
  gesture.dragged = pin;
  gesture.to = to;
  gesture.rests = true;
  std::vector<Stroke> strokes = gesture.strokes(shown().state, settings());
  if (strokes.empty()) return;
  SessionStroke stroke{std::move(strokes.front())};
  if (settings().remesh) stroke.remesh = settings().remesh_settings;
  for (const PinGoal& goal : pin_goals(tools_.placed().pins, pin, to, settings()))
    tools_.placed().pins[goal.pin].place = goal.to;
  apply({std::move(stroke)});
}

std::optional<std::size_t> Studio::pointed_pin() const {
  if (settings().tool->use != ToolUse::pose || shown().opened == 0 || shown().looked_at) return std::nullopt;
  if (const auto* const pins = gesture_ ? std::get_if<PinsGesture>(&gesture_->kind) : nullptr) return pins->dragged;
  if (tools_.placed().lit_pin || !pointer_is_over_view_) return tools_.placed().lit_pin;
  return pin_at(pointer_, gesture_context(), tools_.placed().pins);
}

// As a gesture.
void Studio::apply(std::vector<SessionStroke> strokes) {
  if (!pending_) {
    pending_ = PendingStrokes{shown().state, {}};
    ended_strokes_.clear();
  }
  pending_->strokes = ended_strokes_;
  pending_->strokes.insert(pending_->strokes.end(), strokes.begin(), strokes.end());
  ended_strokes_ = pending_->strokes;
  ++ended_;
  const auto apply = [strokes = std::move(strokes)](Document& document, Progress& progress) {
    document.set_live(strokes, progress);
    document.finish(progress);
  };
  document_.post(apply, settings().tool->name);
}

}  // namespace knead::studio
