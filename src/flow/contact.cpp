// The time at which a moving tool reaches a resting point: next_contact() of closed_form.h.
#include <algorithm>
#include <cmath>

#include "field/grid.h"
#include "flow/closed_form.h"

namespace knead {

namespace {

// Tracing stops at this part of the intermediate region's width before outer. At the same distance behind outer, v is
// still below 1e-10 of the tool's speed.
constexpr double kTraceResolution = 1e-4;

// The path of a resting point in the frame of one field.
struct Approach {
  Vec3d d;         // x - c(t)
  Vec3d velocity;  // of d, per unit of advance
  double t = 0;
  double direction = 1;  // +1 or -1: the sign of time
  double advance = 0;    // the time that is left
};

// The first s >= 0 with |d + s velocity| = radius, for |d| >= radius.
std::optional<double> sphere_contact(const Vec3d& d, const Vec3d& velocity, double radius) {
  const double a = norm2(velocity);
  const double b = -dot(d, velocity);
  const double c = norm2(d) - radius * radius;
  const double discriminant = b * b - a * c;
  if (b <= 0 || discriminant < 0) return std::nullopt;
  return std::max(0.0, c / (b + std::sqrt(discriminant)));
}

std::optional<double> earlier(std::optional<double> a, std::optional<double> b) {
  if (!a) return b;
  if (!b) return a;
  return std::min(*a, *b);
}

std::optional<double> advance_to(const Ball<double>& /*region*/, const Thresholds<double>& thresholds,
                                 const Approach& at) {
  if (norm(at.d) < thresholds.outer) return 0.0;
  return sphere_contact(at.d, at.velocity, thresholds.outer);
}

// A capsule is the union of two end balls and a cylinder, whose discs lie in the balls.
std::optional<double> advance_to(const Capsule<double>& region, const Thresholds<double>& thresholds,
                                 const Approach& at) {
  if (evaluate(region, at.d, 0.0).value < thresholds.outer) return 0.0;
  const Vec3d& h = region.half_axis;
  std::optional<double> first = earlier(sphere_contact(at.d - h, at.velocity, thresholds.outer),
                                        sphere_contact(at.d + h, at.velocity, thresholds.outer));
  const double length = norm(h);
  if (length == 0) return first;
  const Vec3d axis = h / length;
  const Vec3d across = at.d - axis * dot(axis, at.d);
  const Vec3d velocity_across = at.velocity - axis * dot(axis, at.velocity);
  const auto height = [&](double s) { return std::abs(dot(axis, at.d + at.velocity * s)); };
  if (norm(across) <= thresholds.outer) {  // beyond an end, or at the side up to rounding
    return height(0) <= length ? 0.0 : first;
  }
  const std::optional<double> side = sphere_contact(across, velocity_across, thresholds.outer);
  if (side && height(*side) <= length) first = earlier(first, side);
  return first;
}

// Handles move everything but the zero set, where v is 0 anyway.
std::optional<double> advance_to(const Handles<double>& /*region*/, const Thresholds<double>& /*thresholds*/,
                                 const Approach& /*at*/) {
  return 0.0;
}

// The time that may pass before r can be below outer.
double safe_advance(const HalfSpace<double>& region, const Thresholds<double>& thresholds, const Vec3d& d, double r,
                    double speed) {
  const double turning = std::abs(region.turn_angle) * norm(cross(region.turn_axis, d));
  return (r - thresholds.outer) / (speed + turning);
}

double safe_advance(const CustomRegion& region, const Thresholds<double>& thresholds, const Vec3d& /*d*/, double r,
                    double speed) {
  return (r - thresholds.outer) / (region.slope * speed + region.speed);
}

// For points |d(ln r)| <= dl / d_min, for curves 5/4 of it; d_min is the true distance from the set, and at least d_min
// - l after a motion by l. So r stays above outer while l < d_min (1 - (outer/r)^(4/5)), of which 4/5 d_min (1 -
// outer/r) is a lower bound.
double safe_advance(const PointSet<double>& region, const Thresholds<double>& thresholds, const Vec3d& d, double r,
                    double speed) {
  double least2 = kInfinity;
  for (const Vec3d& p : region.points) least2 = std::min(least2, norm2(d - p));
  for (const auto& curve : region.curves) least2 = std::min(least2, squared_distance_to_curve(d, curve));
  const double factor = region.curves.empty() ? 1.0 : 0.8;
  return factor * std::sqrt(least2) * (1 - thresholds.outer / r) / speed;
}

template <class R>
std::optional<double> advance_to(const R& region, const Thresholds<double>& thresholds, const Approach& at) {
  const double width = thresholds.outer - thresholds.inner;
  const double speed = norm(at.velocity);
  for (double s = 0; s <= at.advance;) {
    const Vec3d d = at.d + at.velocity * s;
    const double r = evaluate(region, d, at.t + at.direction * s).value;
    if (r < thresholds.outer + kTraceResolution * width) return s;
    const double safe = safe_advance(region, thresholds, d, r, speed);
    if (!std::isfinite(safe)) return std::nullopt;  // neither the tool nor the region moves
    s += safe;
  }
  return std::nullopt;
}

// Returns the time from t until a segment that is no sum reaches the point; nothing if it does not until `end`.
// `direction`: as in Approach.
std::optional<double> contact_with(const Segment& segment, double end, double direction, const Vec3d& x, double t) {
  if (!segment.grid.is_empty()) {
    return t != end && detail::is_used(segment.grid, x) ? std::optional(0.0) : std::nullopt;
  }
  const bool blended = segment.time_law == TimeLaw::blended;
  const double advance = std::abs(end - t);
  std::optional<double> first;
  for (const Field& field : segment.fields) {
    const auto contact = [&](const Vec3d& d, const Vec3d& velocity) {
      const Approach approach{d, velocity, t, direction, advance};
      return std::visit([&](const auto& region) { return advance_to(region, field.thresholds, approach); },
                        field.region);
    };
    if (blended) {
      first = earlier(first, contact(x - field.center, {}));
      first = earlier(first, contact(x - field.center - segment.displacement, {}));
    } else {
      const Vec3d by = displacement_of(segment, field);
      first = earlier(first, contact(x - field.center - by * t, by * -direction));
    }
  }
  return first && *first < advance ? first : std::nullopt;
}

}  // namespace

std::optional<double> next_contact(const Segment& segment, const Vec3d& x, double t) {
  const double direction = segment.end >= segment.begin ? 1.0 : -1.0;
  std::optional<double> first;
  for (const Segment& part : segment.parts) first = earlier(first, contact_with(part, segment.end, direction, x, t));
  if (segment.parts.empty()) first = contact_with(segment, segment.end, direction, x, t);
  if (!first) return std::nullopt;
  return t + direction * *first;
}

}  // namespace knead
