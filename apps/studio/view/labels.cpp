#include "view/labels.h"

#include <fmt/format.h>

#include <cmath>

#include "gestures/gesture_kinds.h"

namespace knead::studio {

namespace {

constexpr double kArrowPixels = 70;
constexpr double kPointing = 0.5;  // of Drag::depth, above which the arrow is shown

GestureContext around_of(const Studio& studio) {
  const DocumentState& shown = studio.shown();
  const bool fits = shown.picker && shown.picker->fits(shown.state);
  return {studio.screen(), shown.state, fits ? shown.picker.get() : nullptr, studio.settings()};
}

// The drag that would begin at the pointer, of tools that go along a line.
std::optional<Drag> next_drag(const Studio& studio) {
  const ToolSettings& settings = studio.settings();
  const PlacedTools& placed = studio.placed();
  const GestureContext around = around_of(studio);
  if (studio.shown().opened == 0 || studio.shown().looked_at) return std::nullopt;
  if (settings.tool->use == ToolUse::stamp && placed.stamp && placed.placement) {
    return begin_stamp(studio.pointer(), around, placed).drag;
  }
  if (settings.tool->use != ToolUse::pull || !studio.pointer_is_over_view()) return std::nullopt;
  if (!hit_at(studio.pointer(), around)) return std::nullopt;
  return begin_implicit(studio.pointer(), around).drag;
}

const char* word_of(const Amount& amount, bool is_adjusting) {
  switch (amount.kind) {
    case AmountKind::length:
      return is_adjusting ? "Radius" : "Distance";
    case AmountKind::angle:
      return "Angle";
    case AmountKind::percent:
      return is_adjusting ? "Inner ratio" : "Stretch";
  }
  return "";
}

const char* sign_of(AmountKind kind, LengthUnit unit) {
  switch (kind) {
    case AmountKind::length:
      return text_of(unit);
    case AmountKind::angle:
      return "\u00b0";
    case AmountKind::percent:
      return "%";
  }
  return "";
}

std::string with_sign(const std::string& number, AmountKind kind, LengthUnit unit) {
  const bool is_apart = kind == AmountKind::length && unit != LengthUnit::none;
  return number + (is_apart ? " " : "") + sign_of(kind, unit);
}

// Nothing for pins whose stroke is impossible.
std::optional<double> radius_of_gesture(const Studio& studio) {
  const auto* const pins = std::get_if<PinsGesture>(&studio.gesture()->kind);
  if (pins == nullptr) return studio.settings().radius;
  if (!has_exact_pins(studio.settings())) return std::nullopt;
  return radius_of(pins_stroke(pins->pins, pins->dragged, pins->to, studio.settings()));
}

}  // namespace

std::optional<InArrow> in_arrow(const Studio& studio) {
  const Drag* of_gesture = studio.gesture() ? drag_of(*studio.gesture()) : nullptr;
  const std::optional<Drag> next = studio.gesture() ? std::nullopt : next_drag(studio);
  const Drag* const drag = of_gesture != nullptr ? of_gesture : next ? &*next : nullptr;
  if (drag == nullptr || !(drag->depth > kPointing)) return std::nullopt;
  const Screen screen = studio.screen();
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const double away = dot(drag->direction, frame.forward) > 0 ? drag->up : -drag->up;  // upwards is in: 1
  const Vec3d beside = frame.right * (0.5 * kArrowPixels * pixel_size(screen, drag->start));
  const Vec3d along = frame.up * (away * kArrowPixels * pixel_size(screen, drag->start));
  const Vec3d from = drag->start + beside;
  return InArrow{from, from + along};
}

std::string text_of(const Amount& amount, LengthUnit unit) {
  // No more digits than four, and no minus before zero.
  const double value = std::abs(amount.value) < 1e-12 ? 0 : amount.value;
  const std::string number =
      amount.kind == AmountKind::length ? fmt::format("{:.4g}", value) : fmt::format("{:.1f}", value);
  return with_sign(number, amount.kind, unit);
}

std::vector<std::string> numbers_at_pointer(const Studio& studio) {
  const LengthUnit unit = studio.preferences().unit;
  const bool is_painting = studio.gesture() && std::holds_alternative<PaintGesture>(studio.gesture()->kind);
  const std::optional<Amount> amount = studio.amount();
  std::vector<std::string> lines;
  if (amount) {
    const std::string value =
        studio.typed().empty() ? text_of(*amount, unit) : with_sign(studio.typed() + "_", amount->kind, unit);
    lines.push_back(fmt::format("{} {}", word_of(*amount, studio.is_adjusting()), value));
  }
  if (!studio.gesture() || (!amount && !is_painting)) return lines;
  const ToolSettings& settings = studio.settings();
  const std::optional<double> radius = radius_of_gesture(studio);
  if (radius) lines.push_back("Radius " + text_of({AmountKind::length, *radius}, unit));
  if (is_painting) {
    lines.push_back("Depth " + text_of({AmountKind::length, settings.depth * settings.radius}, unit));
  }
  const DocumentState& shown = studio.shown();
  if (shown.volume && shown.volume_before && *shown.volume_before != 0) {
    lines.push_back(fmt::format("Volume {:+.5f}%", 100 * (*shown.volume / *shown.volume_before - 1)));
  }
  return lines;
}

}  // namespace knead::studio
