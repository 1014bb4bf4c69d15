// Shift with any tool: the surface is relaxed along the pointer's path.
#include <algorithm>
#include <cmath>

#include "gestures/gesture_kinds.h"

namespace knead::studio {

namespace {

constexpr double kSpacing = 0.3;  // of the places, in radii
constexpr int kMaxPlaces = 200;   // between two places of the pointer

}  // namespace

std::optional<RelaxGesture> begin_relax(const Pointer& pointer, const GestureContext& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  RelaxGesture gesture;
  gesture.stroke.points = {hit->point};
  gesture.stroke.radius = around.settings.radius;
  if (pointer.modifiers.ctrl) gesture.stroke.surface = 0;
  gesture.last_point = hit->point;
  return gesture;
}

void move_relax(const Pointer& pointer, const GestureContext& around, RelaxGesture& gesture) {
  const auto end = hit_at(pointer, around);
  if (!end) return;
  const double spacing = kSpacing * gesture.stroke.radius;
  const Vec3d from = gesture.last_point;
  const int pieces = std::clamp(static_cast<int>(norm(end->point - from) / spacing), 0, kMaxPlaces);
  for (int i = 1; i <= pieces; ++i) {
    gesture.stroke.points.push_back(from + (end->point - from) * (static_cast<double>(i) / pieces));
  }
  if (pieces > 0) gesture.last_point = end->point;
}

}  // namespace knead::studio
