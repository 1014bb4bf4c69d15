// Packed point sets against point sets.
#include "field/point_sums.h"

#include <gtest/gtest.h>

#include <array>

#include "support/dual.h"
#include "support/random_fields.h"

namespace knead::packed_set_test {
namespace {

using test::Dual;
using test::Random;

template <class S>
PointPacks<S> random_points(Random& random, int count) {
  PointPacks<S> points;
  for (int i = 0; i < count; ++i) points.push_back(Vec3<S>(random.in_box(1)), static_cast<S>(random.integer(1, 5)));
  return points;
}

// 32 bytes of lanes, point by point, and then half onto half: what every instruction set must give bit for bit.
template <class S>
PowerSums<S> sums_by_lanes(const PointPacks<S>& points, const Vec3<S>& d, S scale2, int half) {
  constexpr std::size_t lanes = 32 / sizeof(S);
  std::array<PowerSums<S>, lanes> lane{};
  for (std::size_t i = 0; i < points.count; ++i) {
    add_power(lane[i % lanes], d - points.point(i), points.weight(i), scale2, half);
  }
  for (std::size_t width = lanes / 2; width > 0; width /= 2) {
    for (std::size_t i = 0; i < width; ++i) {
      lane[i].value += lane[i + width].value;
      lane[i].gradient += lane[i + width].gradient;
    }
  }
  return lane[0];
}

template <class S>
void expect_lanes(unsigned seed) {
  Random random(seed);
  for (int i = 0; i < 400; ++i) {
    const PointPacks<S> points = random_points<S>(random, random.integer(1, 60));
    const Vec3<S> d(random.in_box(1.5));
    const int half = random.integer(1, 9);
    const PowerSums<S> expected = sums_by_lanes(points, d, S(0.25), half);
    const PowerSums<S> found = power_sums(points, d, S(0.25), half);
    EXPECT_EQ(found.value, expected.value);
    EXPECT_EQ(found.gradient, expected.gradient);
    EXPECT_EQ(least_squared_distance(points, d), (least_squared_distance<S, S>(points, d)));
  }
}

TEST(PointSums, AreAddedInTheSameLanesEverywhere) {
  expect_lanes<float>(91);
  expect_lanes<double>(92);
}

// Against PointSet's own evaluation in double. In float: m terms' roundings under an m-th root, and the rounding of the
// points themselves against distances of at least 0.02.
TEST(PackedSet, ReadsAsThePointSet) {
  Random random(93);
  for (int i = 0; i < 1000; ++i) {
    const PointSet<double> set = test::random_point_set(random, i % 2 == 0);
    const Vec3d d = random.in_box(1.5);
    const RegionValue<double> expected = evaluate(set, d, 0.0);
    if (expected.value < 0.02) continue;
    const RegionValue<double> in_double = evaluate(packed<double>(set), d, 0.0);
    EXPECT_NEAR(in_double.value, expected.value, 1e-13 * (1 + expected.value));
    EXPECT_LT(norm(in_double.gradient - expected.gradient), 1e-11);
    const RegionValue<float> in_float = evaluate(packed<float>(set), Vec3f(d), 0.0F);
    EXPECT_NEAR(in_float.value, expected.value, 2e-6 * (1 + expected.value));
    EXPECT_LT(norm(Vec3d(in_float.gradient) - expected.gradient), 1e-3);
  }
}

TEST(PackedSet, ReadsTheSameByAnyScale) {
  Random random(94);
  for (int i = 0; i < 500; ++i) {
    PackedSet<double> set = packed<double>(test::random_point_set(random, i % 2 == 0));
    const Vec3d d = random.in_box(1.5);
    const RegionValue<double> expected = evaluate(set, d, 0.0);
    if (expected.value < 0.02) continue;
    set.scale = expected.value * 2;
    const RegionValue<double> scaled = evaluate(set, d, 0.0);
    EXPECT_NEAR(scaled.value, expected.value, 1e-13 * (1 + expected.value));
    EXPECT_LT(norm(scaled.gradient - expected.gradient), 1e-11);
  }
}

TEST(PackedSet, GradientIsThatOfTheValue) {
  Random random(95);
  for (int i = 0; i < 500; ++i) {
    PackedSet<double> set = packed<double>(test::random_point_set(random, i % 2 == 0));
    set.points = std::make_shared<const PointPacks<double>>(random_points<double>(random, 20));
    const RegionValue<Dual> value = evaluate(set, test::variables(random.in_box(1.5)), Dual(0));
    EXPECT_LT(norm(value.value.g - test::values(value.gradient)), 1e-10);
  }
}

TEST(PackedSet, IsExactlyZeroOnEveryElement) {
  Random random(96);
  for (int i = 0; i < 200; ++i) {
    const PointSet<double> set = test::random_point_set(random, i % 2 == 0);
    const PackedSet<double> fast = packed<double>(set);
    for (const Vec3d& p : set.points) EXPECT_EQ(evaluate(fast, p, 0.0).value, 0.0);
    for (const auto& curve : set.curves) EXPECT_EQ(evaluate(fast, curve.front(), 0.0).value, 0.0);
  }
}

}  // namespace
}  // namespace knead::packed_set_test
