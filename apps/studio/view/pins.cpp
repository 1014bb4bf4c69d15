#include "view/pins.h"

#include <utility>

#include "gestures/gesture.h"
#include "gestures/symmetry.h"

namespace knead::studio {

namespace {

constexpr double kNominalPart = 0.05;  // of the radius: how far a pin is moved to show what it takes along
constexpr double kPinPixels = 5;
constexpr render::Color kHeldPin{0.16f, 0.40f, 0.78f, 1};
constexpr render::Color kFreePin{0.92f, 0.92f, 0.90f, 1};

}  // namespace

void add_pins(const Studio& studio, std::vector<render::Line>& lines) {
  if (studio.settings().tool->use != ToolUse::pose || studio.shown().looked_at) return;
  const auto* const drag = studio.gesture() ? std::get_if<PinsGesture>(&studio.gesture()->kind) : nullptr;
  std::vector<Pin> pins = drag != nullptr ? drag->pins : studio.placed().pins;
  const std::optional<std::size_t> lit = studio.pointed_pin();
  const Screen screen = studio.screen();
  const auto add = [&](const Vec3d& place, double pixels, const render::Color& color) {
    const double radius = pixels * pixel_size(screen, place);
    lines.push_back({.points = {place, place + Vec3d{0, 1e-3 * radius, 0}}, .radius = radius, .color = color});
  };
  const std::vector<SymmetryImage> images = images_of(studio.settings());
  if (drag != nullptr) {
    for (const PinGoal& goal : pin_goals(drag->pins, drag->dragged, drag->to, studio.settings())) {
      const Vec3d from = std::exchange(pins[goal.pin].place, goal.to);
      pins[goal.pin].is_selected = true;
      const double radius = 0.25 * kPinPixels * pixel_size(screen, from);
      if (!(from == goal.to)) lines.push_back({.points = {from, goal.to}, .radius = radius, .color = kPlaced});
    }
  }
  for (std::size_t i = 0; i < pins.size(); ++i) {
    const bool is_lit = drag == nullptr && i == lit;
    const render::Color color = is_lit                ? kLitHandle
                                : pins[i].is_selected ? kPlaced
                                : pins[i].holds       ? kHeldPin
                                                      : kFreePin;
    add(pins[i].place, kPinPixels, color);
    for (const SymmetryImage& image : images) add(image.motion(pins[i].place), 0.6 * kPinPixels, color);
  }
}

std::optional<PinsStroke> hovering_pins(const Studio& studio) {
  const std::vector<Pin>& pins = studio.placed().pins;
  if (pins.empty()) return std::nullopt;
  const std::size_t pin = studio.pointed_pin().value_or(pins.size() - 1);
  const Vec3d by = render::camera_frame(studio.screen().camera).up * (kNominalPart * studio.radius());
  return pins_stroke(pins, pin, pins[pin].place + by, studio.settings());
}

}  // namespace knead::studio
