#include "knead/tool/slipping.h"

#include <algorithm>

namespace knead::tool_detail {

namespace {

// Closer pins follow the tool no better, and their equations take longer.
constexpr double kPinsPerRadius = 5;
// Of a step's motion: what is not deeper inside the tool counts as outside.
constexpr double kShallow = 0.01;
// Of the distance between pins: two of them cannot meet. What lies deeper comes out step by step. Twice the default
// step.
constexpr double kLongest = 0.4;
// Of a round; what is left moves in the next one, or is not held. A pins stroke may have 2000.
constexpr std::size_t kMostMoving = 1000;
constexpr std::size_t kMostPins = 1900;

}  // namespace

void SlippingContacts::hold_what_touches(const LiveSurface& surface, const StampStep& step, double distance) {
  Thinned pressed(radius_ / kPinsPerRadius / 2);
  for (const Place& place : find_touching(tool_, surface, step, distance)) {
    if (pressed.take(place.at(surface.positions))) pressed_.push_back(place);
  }
}

std::optional<PinsStroke> SlippingContacts::pins(const LiveSurface& surface, const StampStep& step) {
  const double spacing = radius_ / kPinsPerRadius;
  const double length = norm(step.motion);
  const StampStep sampled{step.to, step.motion, spacing, step.threads};
  const std::vector<Intrusion> found = find_intrusions(tool_, surface, sampled);
  if (found.empty() || norm(found.front().way) < kShallow * length) return std::nullopt;
  PinsStroke stroke;
  stroke.radius = radius_;
  Thinned pinned(spacing);
  std::vector<Intrusion> moving;
  for (const Intrusion& intrusion : found) {
    if (moving.size() == kMostMoving) break;
    if (!pinned.take(intrusion.point)) continue;
    const double part = std::min(1.0, kLongest * spacing / norm(intrusion.way));
    stroke.points.push_back(intrusion.point);
    stroke.to.push_back(intrusion.point + intrusion.way * part);
    moving.push_back(intrusion);
  }
  Thinned pressed(spacing / 2);
  std::erase_if(pressed_, [&](const Place& place) {
    const Vec3d point = place.at(surface.positions);
    if (is_near(point, moving) && stroke.points.size() < kMostPins && pinned.take(point)) {
      stroke.points.push_back(point);
      stroke.to.push_back(point);
    }
    return !pressed.take(point);
  });
  for (const Intrusion& intrusion : moving) {
    if (pressed.take(intrusion.point)) pressed_.push_back(intrusion.place);
  }
  return stroke;
}

bool SlippingContacts::is_near(const Vec3d& point, const std::vector<Intrusion>& moving) const {
  return std::any_of(moving.begin(), moving.end(),
                     [&](const Intrusion& each) { return norm2(each.point - point) < radius_ * radius_; });
}

}  // namespace knead::tool_detail
