// Random segments of every kind that tools make, of about unit size.
#pragma once

#include <string>
#include <vector>

#include "knead/flow/advect.h"
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

// One segment of every kind: every tool, swept and blended.
inline std::vector<NamedSegment> random_segments(Random& random) {
  const auto center = [&] { return random.in_box(0.3); };
  const auto thresholds = [&] {
    const double outer = random.uniform(0.4, 0.9);
    return Thresholds<double>{outer * random.uniform(0.1, 0.75), outer};
  };
  const Vec3d by = random.unit() * random.uniform(0.1, 0.8);
  const Vec3d half = random.in_box(0.4);
  const Vec3d axis = random.unit();
  const Vec3d normal = normalized(cross(axis, random.unit()));
  const double angle = random.uniform(-1.0, 1.0);
  const Thresholds<double> slab{random.uniform(-0.5, -0.3), random.uniform(0.3, 0.5)};
  const Mat3d squash = (outer_product(axis, axis) * 1.5 + Mat3d{} * -0.5) * random.uniform(-0.7, 0.7);
  std::vector<NamedSegment> result;
  result.push_back({"ball", translating(Ball<double>{}, center(), by, thresholds())});
  result.push_back({"painting ball", translating(Ball<double>{}, center(), by * 0.5, {0, 0.5})});
  result.push_back({"capsule", translating(Capsule<double>{half}, center(), by, thresholds(), normalized(half), 0.0)});
  result.push_back({"blended ball", translating(Ball<double>{}, center(), by, thresholds())});
  result.back().segment.time_law = TimeLaw::blended;
  result.push_back(
      {"blended capsule", translating(Capsule<double>{half}, center(), by * 0.5, thresholds(), normalized(half), 0.0)});
  result.back().segment.time_law = TimeLaw::blended;
  result.push_back({"points", translating(random_point_set(random, false), center(), by * 0.5, {0, 0.4})});
  result.push_back({"curves", translating(random_point_set(random, true), center(), by * 0.5, {0, 0.4})});
  Segment parts = translating(Ball<double>{}, {-0.5, 0, 0}, by * 0.5, {0, 0.4});
  parts.fields.push_back(parts.fields.front());
  parts.fields.back().center = {0.5, 0, 0};
  result.push_back({"two parts", parts});
  result.push_back({"rotate", resting(Rotation<double>{axis, angle, random.uniform(0, 1), RotationGauge::radial},
                                      Ball<double>{}, center(), thresholds())});
  result.push_back({"stretch", resting(Strain<double>{squash}, Ball<double>{}, center(), thresholds())});
  result.push_back(
      {"strain", resting(Strain<double>{random_traceless(random) * 0.5}, Ball<double>{}, center(), thresholds())});
  result.push_back(
      {"twist", resting(Twist<double>{axis, angle, random.uniform(0, 1)}, HalfSpace<double>{axis}, center(), slab)});
  result.push_back({"oblique twist", resting(Twist<double>{axis, angle, random.uniform(0, 1)},
                                             HalfSpace<double>{normal}, center(), slab)});
  result.push_back({"bend", resting(Rotation<double>{axis, angle, random.uniform(0, 1)},
                                    HalfSpace<double>{normal, axis, angle / 2}, center(), slab)});
  return result;
}

// The same deformation, with a second field that is zero wherever the tests have points: no closed form applies to it.
inline Segment without_closed_form(Segment segment) {
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
