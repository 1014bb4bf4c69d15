// Random fields, positions and thresholds from a seeded generator.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "knead/field.h"

namespace knead::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  // Not by std::uniform_int_distribution, which gives other numbers in each C++ library.
  int integer(int low, int high) {
    const auto count = static_cast<std::uint64_t>(high - low + 1);
    return low + static_cast<int>(std::uint64_t{engine_()} * count >> 32);
  }
  Vec3d in_box(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Vec3d unit() {
    for (;;) {
      const Vec3d v = in_box(1);
      if (norm2(v) > 0.01 && norm2(v) < 1) return normalized(v);
    }
  }

 private:
  std::mt19937 engine_;
};

inline Mat3d random_traceless(Random& random) {
  Mat3d m{random.in_box(1), random.in_box(1), random.in_box(1)};
  m.row2.z = -(m.row0.x + m.row1.y);
  return m;
}

// All motions, each with a random gauge.
inline std::vector<Motion> random_motions(Random& random) {
  const double gauge = random.uniform(-0.5, 1.5);
  return {Translation<double>{random.in_box(2), random.unit(), gauge},
          Rotation<double>{random.unit(), random.uniform(-3, 3), gauge, RotationGauge::radial},
          Rotation<double>{random.unit(), random.uniform(-3, 3), gauge, RotationGauge::axial},
          Twist<double>{random.unit(), random.uniform(-3, 3), gauge}, Strain<double>{random_traceless(random)}};
}

inline PointSet<double> random_point_set(Random& random, bool with_curves) {
  PointSet<double> set;
  const std::array<int, 6> exponents = {2, 4, 6, 8, 10, 16};
  set.exponent = exponents[static_cast<std::size_t>(random.integer(0, 5))];
  const int points = with_curves ? random.integer(0, 3) : random.integer(1, 12);
  for (int i = 0; i < points; ++i) set.points.push_back(random.in_box(0.8));
  if (with_curves) {
    for (int c = random.integer(1, 2); c > 0; --c) {
      std::vector<Vec3d> curve{random.in_box(0.8)};
      for (int i = random.integer(1, 5); i > 0; --i) curve.push_back(curve.back() + random.in_box(0.4));
      set.curves.push_back(curve);
    }
  }
  return set;
}

// Points of a full set about `by` and of a zero set about -by.
inline Handles<double> random_handles(Random& random, const Vec3d& by) {
  Handles<double> handles{random_point_set(random, false), random_point_set(random, false)};
  for (Vec3d& p : handles.full.points) p = p * 0.4 + by;
  for (Vec3d& p : handles.zero.points) p = p * 0.4 - by;
  return handles;
}

inline std::vector<Region> random_regions(Random& random) {
  Handles<double> swept = random_handles(random, random.in_box(0.5));
  swept.sweep = random.in_box(0.5);
  Handles<double> turned = random_handles(random, random.in_box(0.5));
  turned.turn_axis = random.unit();
  turned.turn_angle = random.uniform(-2, 2);
  return {Ball<double>{},
          Capsule<double>{random.in_box(0.7)},
          HalfSpace<double>{random.unit()},
          HalfSpace<double>{random.unit(), random.unit(), random.uniform(-2, 2)},
          random_point_set(random, false),
          random_point_set(random, true),
          swept,
          turned};
}

inline Thresholds<double> random_thresholds(Random& random) {
  const double inner = random.uniform(0.02, 0.6);
  return {inner, inner + random.uniform(0.2, 1.0)};
}

}  // namespace knead::test
