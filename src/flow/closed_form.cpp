// Closed forms of path lines, for one point at a time; kernel_stage.h has them for packs.
#include "flow/closed_form.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>

#include "knead/vec.h"

namespace knead {

namespace {

// d turned about the unit axis by the angle, minus d; without cancellation for small angles.
Vec3d turn_displacement(const Vec3d& d, const Vec3d& axis, double angle) {
  constexpr double kMaxForSinCos = 1e4;  // far up a twist angles are greater
  if (std::abs(angle) > kMaxForSinCos) angle = std::remainder(angle, 2 * std::numbers::pi);
  const double half_sine = sincos(0.5 * angle).sin;
  const Vec3d d_perp = d - axis * dot(axis, d);
  return cross(axis, d) * sincos(angle).sin - d_perp * (2 * half_sine * half_sine);
}

bool is_parallel(const Vec3d& a, const Vec3d& b) { return norm2(cross(a, b)) <= 1e-24 * norm2(a) * norm2(b); }

// The maximum over the angles from phi0 to phi1 of n(phi).d, n turning about the unit axis: a sinusoid
// level + cosine cos(phi) + sine sin(phi). For half a turn or more, its global maximum.
double greatest_over_turn(const Vec3d& n, const Vec3d& axis, const Vec3d& d, double phi0, double phi1) {
  const double level = dot(axis, n) * dot(axis, d);
  const double cosine = dot(n, d) - level;
  const double sine = dot(cross(axis, n), d);
  const double amplitude = std::sqrt(cosine * cosine + sine * sine);
  if (std::abs(phi1 - phi0) >= std::numbers::pi) return level + amplitude;
  const SinCos<double> low = sincos(std::min(phi0, phi1));
  const SinCos<double> high = sincos(std::max(phi0, phi1));
  const bool rises = sine * low.cos - cosine * low.sin > 0;
  const bool falls = sine * high.cos - cosine * high.sin < 0;
  if (rises && falls) return level + amplitude;
  return level + std::max(cosine * low.cos + sine * low.sin, cosine * high.cos + sine * high.sin);
}

// Returns whether r is never negative, so that no point is below a threshold of 0.
bool is_distance(const HalfSpace<double>& /*region*/) { return false; }
bool is_distance(const CustomRegion& /*region*/) { return false; }
bool is_distance(const auto& /*region*/) { return true; }

// A translation with its tool: a point of the inner region rests in the tool's frame.
std::optional<Vec3d> solve(const Translation<double>& motion, const auto& region, const Segment& segment,
                           const Vec3d& x) {
  const Field& field = segment.fields.front();
  if (segment.time_law != TimeLaw::swept || motion.velocity != segment.displacement) return std::nullopt;
  if (field.thresholds.inner <= 0 && is_distance(region)) return std::nullopt;
  const Vec3d d = x - field.center - segment.displacement * segment.begin;
  if (evaluate(region, d, segment.begin).value >= field.thresholds.inner) return std::nullopt;
  return segment.displacement * (segment.end - segment.begin);
}

std::optional<Vec3d> solve(const Rotation<double>& motion, const Ball<double>& region, const Segment& segment,
                           const Vec3d& x) {
  const Field& field = segment.fields.front();
  if (segment.displacement != Vec3d{0, 0, 0} || motion.zero_gauge != RotationGauge::radial) return std::nullopt;
  const Vec3d d = x - field.center;
  const double r = evaluate(region, d, 0.0).value;
  const Weight<double> w = blend_weight(r, field.thresholds);
  const double height = dot(motion.axis, d);
  const double rho2 = norm2(d - motion.axis * height);
  const double counter = r > 0 ? motion.gauge * w.derivative * (height * height + 0.5 * rho2) / (2 * r) : 0.0;
  const double angle = motion.rate * (w.value + counter) * (segment.end - segment.begin);
  return turn_displacement(d, motion.axis, angle);
}

// n.d over the path line of a point that turns about the axis by `angle` over the unit of time, while n turns by
// turn_angle: in the point's frame n turns by turn_angle - angle, about the same axis.
bool stays_inside(const Segment& segment, const HalfSpace<double>& region, const Vec3d& axis, const Vec3d& d,
                  double angle) {
  const bool turning = region.turn_angle != 0;
  if (turning && !is_parallel(region.turn_axis, axis)) return false;
  const double turn = turning ? region.turn_angle * (dot(region.turn_axis, axis) > 0 ? 1.0 : -1.0) : 0.0;
  const double phi0 = segment.begin * turn;
  const double phi1 = phi0 + (segment.end - segment.begin) * (turn - angle);
  return greatest_over_turn(region.normal, axis, d, phi0, phi1) < segment.fields.front().thresholds.inner;
}

std::optional<Vec3d> solve(const Rotation<double>& motion, const HalfSpace<double>& region, const Segment& segment,
                           const Vec3d& x) {
  const Vec3d d = x - segment.fields.front().center;
  if (segment.displacement != Vec3d{0, 0, 0}) return std::nullopt;
  if (!stays_inside(segment, region, motion.axis, d, motion.rate)) return std::nullopt;
  return turn_displacement(d, motion.axis, motion.rate * (segment.end - segment.begin));
}

std::optional<Vec3d> solve(const Twist<double>& motion, const HalfSpace<double>& region, const Segment& segment,
                           const Vec3d& x) {
  const Field& field = segment.fields.front();
  const Vec3d d = x - field.center;
  const double height = dot(motion.axis, d);
  const double duration = segment.end - segment.begin;
  if (segment.displacement != Vec3d{0, 0, 0} || region.turn_angle != 0) return std::nullopt;
  if (!is_parallel(region.normal, motion.axis)) {
    const double rate = motion.rate * height;
    if (!stays_inside(segment, region, motion.axis, d, rate)) return std::nullopt;
    return turn_displacement(d, motion.axis, rate * duration);
  }
  const Weight<double> w = blend_weight(dot(region.normal, d), field.thresholds);
  const double counter = 0.25 * motion.gauge * w.derivative * dot(region.normal, motion.axis) * height;
  return turn_displacement(d, motion.axis, motion.rate * height * (w.value + counter) * duration);
}

// |exp(t M) d|^2 is convex in t for a symmetric M: its greatest value is at an end.
std::optional<Vec3d> solve(const Strain<double>& motion, const Ball<double>& /*region*/, const Segment& segment,
                           const Vec3d& x) {
  const Field& field = segment.fields.front();
  const Mat3d& m = motion.matrix;
  const bool symmetric = m.row0.y == m.row1.x && m.row0.z == m.row2.x && m.row1.z == m.row2.y;
  if (segment.displacement != Vec3d{0, 0, 0} || !symmetric) return std::nullopt;
  const Vec3d d = x - field.center;
  if (norm(d) >= field.thresholds.inner) return std::nullopt;
  const Vec3d moved = exp(m * (segment.end - segment.begin)) * d;
  if (norm(moved) >= field.thresholds.inner) return std::nullopt;
  return moved - d;
}

bool has_point(std::span<const Vec3d> points, const Vec3d& d, double slack) {
  return std::any_of(points.begin(), points.end(), [&](const Vec3d& p) {
    return std::abs(d.x - p.x) <= slack && std::abs(d.y - p.y) <= slack && std::abs(d.z - p.z) <= slack;
  });
}

bool before(const Vec3d& p, const Vec3d& q) { return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z); }

// The same for points in that order.
bool has_sorted_point(std::span<const Vec3d> points, const Vec3d& d, double slack) {
  if (slack == 0) return std::binary_search(points.begin(), points.end(), d, before);
  const auto by_x = [](const Vec3d& p, double x) { return p.x < x; };
  const auto first = std::lower_bound(points.begin(), points.end(), d.x - 2 * slack, by_x);
  const auto last = std::lower_bound(first, points.end(), d.x + 2 * slack, by_x);
  return has_point({first, last}, d, slack);
}

// Returns the set of the handles that x is a point of: up to the rounding of positions where the segment does not begin
// at t = 0, and only exactly for the zero set, whose points do not move. `has` searches a set.
enum class HandleSet { full, zero, none };
template <class Has>
HandleSet set_of(const Handles<double>& region, const Segment& segment, const Vec3d& x, const Has& has) {
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  const Vec3d& c = segment.fields.front().center;
  if (has(HandleSet::zero, x - c, 0.0)) return HandleSet::zero;
  const Vec3d d = x - c - segment.displacement * segment.begin;
  const double angle = -region.turn_angle * segment.begin;
  const Vec3d at_start = angle == 0 ? d : rotate(d, region.turn_axis, sincos(angle));
  const double slack = segment.begin == 0 ? 0 : kRounding * (norm(x) + norm(c) + norm(segment.displacement));
  return has(HandleSet::full, at_start, slack) ? HandleSet::full : HandleSet::none;
}

// The points of the sets, with a motion that is the full set's own.
std::optional<Vec3d> follow(const Translation<double>& motion, const Handles<double>& /*region*/,
                            const Segment& segment, const Vec3d& /*x*/) {
  if (motion.velocity != segment.displacement) return std::nullopt;
  return segment.displacement * (segment.end - segment.begin);
}

std::optional<Vec3d> follow(const Rotation<double>& motion, const Handles<double>& region, const Segment& segment,
                            const Vec3d& x) {
  const bool own = motion.rate == region.turn_angle && motion.axis == region.turn_axis;
  if (!own || segment.displacement != Vec3d{0, 0, 0}) return std::nullopt;
  return turn_displacement(x - segment.fields.front().center, motion.axis, motion.rate * (segment.end - segment.begin));
}

std::optional<Vec3d> follow(const auto& /*motion*/, const Handles<double>& /*region*/, const Segment& /*segment*/,
                            const Vec3d& /*x*/) {
  return std::nullopt;
}

std::optional<Vec3d> solve_point(const auto& motion, const Handles<double>& region, const Segment& segment,
                                 const Vec3d& x, HandleSet set) {
  if (set == HandleSet::zero) return Vec3d{0, 0, 0};
  return set == HandleSet::full ? follow(motion, region, segment, x) : std::nullopt;
}

std::optional<Vec3d> solve_any_point(const auto& motion, const Handles<double>& region, const Segment& segment,
                                     const Vec3d& x) {
  const auto has = [&](HandleSet set, const Vec3d& d, double slack) {
    return has_point(set == HandleSet::full ? region.full.points : region.zero.points, d, slack);
  };
  return solve_point(motion, region, segment, x, set_of(region, segment, x, has));
}

std::optional<Vec3d> solve(const Translation<double>& motion, const Handles<double>& region, const Segment& segment,
                           const Vec3d& x) {
  return solve_any_point(motion, region, segment, x);
}

std::optional<Vec3d> solve(const Rotation<double>& motion, const Handles<double>& region, const Segment& segment,
                           const Vec3d& x) {
  return solve_any_point(motion, region, segment, x);
}

std::optional<Vec3d> solve(const auto& /*motion*/, const auto& /*region*/, const Segment& /*segment*/,
                           const Vec3d& /*x*/) {
  return std::nullopt;
}

}  // namespace

std::optional<Vec3d> closed_form(const Segment& segment, const Vec3d& x) {
  if (segment.fields.size() != 1 || segment.time_law != TimeLaw::swept) return std::nullopt;
  const Field& field = segment.fields.front();
  return std::visit([&](const auto& motion, const auto& region) { return solve(motion, region, segment, x); },
                    field.motion, field.region);
}

HandlePoints::HandlePoints(const Segment& segment) {
  const Field& field = segment.fields.front();
  const auto* region = std::get_if<Handles<double>>(&field.region);
  const bool moves = std::holds_alternative<Translation<double>>(field.motion) ||
                     std::holds_alternative<Rotation<double>>(field.motion);
  if (region == nullptr || !moves || segment.fields.size() != 1 || segment.time_law != TimeLaw::swept) return;
  full_ = region->full.points;
  zero_ = region->zero.points;
  std::sort(full_.begin(), full_.end(), before);
  std::sort(zero_.begin(), zero_.end(), before);
}

std::optional<Vec3d> HandlePoints::closed_form(const Segment& segment, const Vec3d& x) const {
  const Field& field = segment.fields.front();
  const auto& region = std::get<Handles<double>>(field.region);
  const auto has = [&](HandleSet set, const Vec3d& d, double slack) {
    return has_sorted_point(set == HandleSet::full ? full_ : zero_, d, slack);
  };
  const HandleSet set = set_of(region, segment, x, has);
  return std::visit([&](const auto& motion) { return solve_point(motion, region, segment, x, set); }, field.motion);
}

}  // namespace knead
