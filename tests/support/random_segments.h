// Random segments of every kind that tools make, of about unit size.
#pragma once

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "knead/flow.h"
#include "support/random_fields.h"

namespace knead::test {

struct NamedSegment {
  std::string name;
  Segment segment;
};

inline Segment translating(const Region& region, const Vec3d& c, const Vec3d& by, Thresholds<double> thresholds,
                           const Vec3d& axis = {}, double gauge = 1) {
  Segment segment;
  segment.fields = {{c, Translation<double>{by, axis, gauge}, region, thresholds}};
  segment.displacement = by;
  return segment;
}

inline Segment resting(const Motion& motion, const Region& region, const Vec3d& c, Thresholds<double> thresholds) {
  Segment segment;
  segment.fields = {{c, motion, region, thresholds}};
  return segment;
}

// Pins that move by up to `by` or, every other one, rest; no two of them nearer than a quarter of the radius on the
// way.
inline Segment pinning(Random& random, int count, double radius, double by, double size = 0.6) {
  Segment segment;
  segment.time_law = TimeLaw::pinned;
  const auto is_near = [&](const Vec3d& place, const Vec3d& u) {
    for (const Field& field : segment.fields) {
      const Vec3d d = place - field.center;
      const Vec3d v = u - std::get<Translation<double>>(field.motion).velocity;
      const double t = norm2(v) > 0 ? std::clamp(-dot(d, v) / norm2(v), 0.0, 1.0) : 0.0;
      if (norm(d + v * t) < 0.25 * radius) return true;
    }
    return false;
  };
  while (static_cast<int>(segment.fields.size()) < count) {
    const Vec3d place = random.in_box(size);
    const Vec3d u = random.in_box(by) * static_cast<double>(segment.fields.size() % 2 == 0);
    if (is_near(place, u)) continue;
    segment.fields.push_back({place, Translation<double>{u}, Ball<double>{}, {0, radius, kPinFalloff}});
  }
  return segment;
}

// The same pins, of which two of three turn, or hold their directions.
inline Segment turning(Segment segment) {
  for (std::uint32_t i = 0; i < segment.fields.size(); ++i) {
    const Vec3d rate{0.2 - 0.3 * (i % 4), 0.1 * (i % 5), i % 2 == 0 ? 0.7 : -0.4};
    if (i % 3 != 1) segment.turns.push_back({i, i == 3 ? Vec3d{0, 0, 0} : rate});
  }
  return segment;
}

// Gives thresholds a falloff. The bump of the wide one lies a third of the way from `inner` to `outer`.
inline void set_falloff(Thresholds<double>& thresholds, int falloff) {
  thresholds.falloff = falloff;
  if (falloff == kWideFalloff) thresholds.bump = thresholds.inner + (thresholds.outer - thresholds.inner) / 3;
}

// One segment of every kind that has the falloff: every tool, swept and blended. Numbers are drawn one statement after
// the other, so that every compiler draws the same.
inline std::vector<NamedSegment> random_segments(Random& random, int falloff = kDefaultFalloff) {
  struct BallNumbers {
    Vec3d center;
    Thresholds<double> thresholds;
  };
  const auto ball = [&] {
    BallNumbers result;
    result.center = random.in_box(0.3);
    const double outer = random.uniform(0.4, 0.9);
    result.thresholds = {outer * random.uniform(0.1, 0.75), outer};
    return result;
  };
  const Vec3d direction = random.unit();
  const Vec3d by = direction * random.uniform(0.1, 0.8);
  const Vec3d half = random.in_box(0.4);
  const Vec3d axis = random.unit();
  const Vec3d normal = normalized(cross(axis, random.unit()));
  const double angle = random.uniform(-0.5, 0.5);
  const double gauge = random.uniform(0, 1);
  const Vec3d near = random.in_box(0.1);
  const double slab_inner = random.uniform(-0.5, -0.4);
  const Thresholds<double> slab{slab_inner, random.uniform(0.4, 0.5)};
  const Mat3d squash = (outer_product(axis, axis) * 1.5 + Mat3d{} * -0.5) * random.uniform(-0.7, 0.7);
  const Mat3d traceless = random_traceless(random) * 0.5;
  const PointSet<double> points = random_point_set(random, false);
  const PointSet<double> curves = random_point_set(random, true);
  std::vector<NamedSegment> result;
  BallNumbers b = ball();
  result.push_back({"ball", translating(Ball<double>{}, b.center, by, b.thresholds)});
  result.push_back({"painting ball", translating(Ball<double>{}, b.center, by * 0.5, {0, 0.5})});
  b = ball();
  result.push_back({"capsule", translating(Capsule<double>{half}, b.center, by, b.thresholds, normalized(half), 0.0)});
  b = ball();
  result.push_back({"blended ball", translating(Ball<double>{}, b.center, by, b.thresholds)});
  result.back().segment.time_law = TimeLaw::blended;
  b = ball();
  result.push_back(
      {"blended capsule", translating(Capsule<double>{half}, b.center, by * 0.5, b.thresholds, normalized(half), 0.0)});
  result.back().segment.time_law = TimeLaw::blended;
  result.push_back({"points", translating(points, near, by * 0.5, {0, 0.4})});
  result.push_back({"curves", translating(curves, near, by * 0.5, {0, 0.4})});
  Segment parts = translating(Ball<double>{}, {-0.5, 0, 0}, by * 0.5, {0, 0.4});
  parts.fields.push_back(parts.fields.front());
  parts.fields.back().center = {0.5, 0, 0};
  result.push_back({"two parts", parts});
  b = ball();
  const Rotation<double> turn{axis, 2 * angle, gauge, RotationGauge::radial};
  result.push_back({"rotate", resting(turn, Ball<double>{}, b.center, b.thresholds)});
  b = ball();
  result.push_back({"stretch", resting(Strain<double>{squash}, Ball<double>{}, b.center, b.thresholds)});
  result.push_back({"strain", resting(Strain<double>{traceless}, Ball<double>{}, b.center, b.thresholds)});
  const Twist<double> twist{axis, angle, gauge};
  result.push_back({"twist", resting(twist, HalfSpace<double>{axis}, near, slab)});
  result.push_back({"oblique twist", resting(twist, HalfSpace<double>{normal}, near, slab)});
  const Rotation<double> bend{axis, angle, gauge};
  result.push_back({"bend", resting(bend, HalfSpace<double>{normal, axis, angle / 2}, near, slab)});
  Handles<double> swept = random_handles(random, random.unit() * 0.5);
  swept.sweep = by * 0.5;
  result.push_back({"swept handles", translating(swept, near, by * 0.5, {0, 1})});
  Handles<double> turned = random_handles(random, random.unit() * 0.5);
  turned.turn_axis = axis;
  turned.turn_angle = 2 * angle;
  result.push_back({"turned handles", resting(Rotation<double>{axis, 2 * angle}, turned, near, {0, 1})});
  const bool wide = falloff == kWideFalloff;
  if (wide) {
    std::erase_if(result, [](const NamedSegment& named) {
      return !std::holds_alternative<Ball<double>>(named.segment.fields.front().region);
    });
  }
  for (NamedSegment& named : result) {
    for (Field& field : named.segment.fields) set_falloff(field.thresholds, falloff);
  }
  if (wide) return result;
  result.push_back({"pins", pinning(random, 5, 0.8, 0.3)});
  result.push_back({"turning pins", turning(result.back().segment)});
  return result;
}

// The falloffs besides the default.
inline constexpr int kOtherFalloffs[] = {3, 5, 6, 7, kWideFalloff};

// The same deformation, with a second field that is zero wherever the tests have points: no closed form applies to it.
inline Segment without_closed_form(Segment segment) {
  if (segment.time_law == TimeLaw::pinned) return segment;  // has none
  Field idle{{1e6, 0, 0}, Translation<double>{}, Ball<double>{}, {0, 1e5}};
  segment.fields.push_back(idle);
  return segment;
}

// In a slab of a bend or twist v grows with the square of the distance from the axis, so that path lines far out run to
// infinity in finite time; within this size they do not.
inline std::vector<Vec3d> random_points(Random& random, int count, double size = 0.6) {
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i) points.push_back(random.in_box(size));
  return points;
}

inline AdvectOptions precisely(double tolerance = 1e-11) {
  AdvectOptions options;
  options.tolerance = tolerance;
  options.precision = Precision::float64;
  return options;
}

// The defaults but for the tolerance, of shapes about 1 in size.
inline AdvectOptions in_float(double tolerance = kDefaultRelativeTolerance) {
  AdvectOptions options;
  options.tolerance = tolerance;
  return options;
}

inline std::vector<Vec3d> moved(const Flow& flow, std::vector<Vec3d> points, const AdvectOptions& options) {
  const AdvectResult result = advect(flow, points, options);
  if (result.status != AdvectStatus::done) throw std::runtime_error("a path line did not come to its end");
  return points;
}

inline double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, norm(a[i] - b[i]));
  return worst;
}

}  // namespace knead::test
