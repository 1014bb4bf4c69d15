// Masks: their values, smoothness and representative points.
#include "knead/field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "field/mask_grid.h"
#include "knead/error.h"
#include "support/dual.h"
#include "support/random_fields.h"

namespace knead::mask_test {
namespace {

using test::Dual;
using test::Random;

constexpr double kWidth = 0.3;

std::vector<Vec3d> some_points(Random& random, int count) {
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i) points.push_back(random.in_box(0.8));
  return points;
}

std::vector<double> some_values(Random& random, std::size_t count) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(i % 3 == 0 ? 1 : random.uniform(0, 1));
  return values;
}

TEST(Mask, IsZeroAtItsPointsAndOneAwayFromThem) {
  Random random(401);
  const std::vector<Vec3d> points = some_points(random, 60);
  const Mask mask(points, {}, kWidth);
  for (const Vec3d& p : points) {
    EXPECT_TRUE(mask.holds(p));
    EXPECT_EQ(mask.at(p).value, 0);
    EXPECT_EQ(mask.at(p).gradient, (Vec3d{0, 0, 0}));
    EXPECT_LT(mask.at(p + random.unit() * (0.25 * kWidth)).value, 0.25);
  }
  int away = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3d x = random.in_box(2);
    double nearest = 100;
    for (const Vec3d& p : points) nearest = std::fmin(nearest, norm(x - p));
    if (nearest < 1.5 * kWidth) continue;
    ++away;
    EXPECT_EQ(mask.at(x).value, 1);
    EXPECT_EQ(mask.at(x).gradient, (Vec3d{0, 0, 0}));
    EXPECT_FALSE(mask.holds(x));
  }
  EXPECT_GT(away, 5000);
  const Mask one(std::vector<Vec3d>{{0, 0, 0}}, {}, kWidth);
  EXPECT_EQ(one.at({kWidth, 0, 0}).value, 1);
  EXPECT_EQ(one.at({0, 0, -kWidth}).value, 1);
  EXPECT_LT(one.at({0.4 * kWidth, 0, 0}).value, 0.6);
}

TEST(Mask, TakesTheValuesOfItsPoints) {
  for (const double value : {0.1, 0.25, 0.5, 0.9}) {
    const Mask mask(std::vector<Vec3d>{{0.3, 0.2, 0.1}}, std::vector<double>{value}, kWidth);
    EXPECT_NEAR(mask.at({0.3, 0.2, 0.1}).value, 1 - value, 0.5 / 255 + 1e-12);
    EXPECT_FALSE(mask.holds({0.3, 0.2, 0.1}));
  }
  EXPECT_TRUE(Mask(std::vector<Vec3d>{{0, 0, 0}}, std::vector<double>{0}, kWidth).is_empty());
}

// Along lines: m in [0, 1], and gradient and curvature agree with differences, also across cells and bricks.
TEST(Mask, IsTwiceContinuouslyDifferentiable) {
  Random random(402);
  const std::vector<Vec3d> points = some_points(random, 40);
  const Mask mask(points, some_values(random, points.size()), kWidth);
  const double h = 1e-6 * kWidth;
  double worst_slope = 0;
  double worst_jump = 0;
  double steepest = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3d x = random.in_box(1.2);
    const MaskValue<double> m = mask.at(x);
    EXPECT_GE(m.value, -1e-12);
    EXPECT_LE(m.value, 1 + 1e-12);
    const Vec3d e = random.unit() * h;
    const double slope = (mask.at(x + e).value - mask.at(x - e).value) / (2 * h);
    steepest = std::fmax(steepest, norm(m.gradient));
    worst_slope = std::fmax(worst_slope, std::abs(slope - dot(m.gradient, e) / h) * kWidth);
  }
  EXPECT_LT(worst_slope, 1e-8);  // rounding of m by h
  EXPECT_GT(steepest * kWidth, 1);
  EXPECT_LT(steepest * kWidth, 6);
  // Second differences of neighbouring pairs differ by no more than a third derivative allows: no jump at a node.
  const double spacing = kWidth / 8;
  const double step = 1e-3 * spacing;
  for (int i = 0; i < 400; ++i) {
    Vec3d x = points[static_cast<std::size_t>(i) % points.size()] + random.in_box(kWidth);
    x.x = std::round(x.x / spacing) * spacing;
    const Vec3d e{step, 0, 0};
    const double before = (mask.at(x).gradient.x - mask.at(x - e).gradient.x) / step;
    const double after = (mask.at(x + e).gradient.x - mask.at(x).gradient.x) / step;
    worst_jump = std::fmax(worst_jump, std::abs(after - before) * spacing * spacing);
  }
  EXPECT_LT(worst_jump, 1e-2);  // third derivative in cells, at most 6, times 1e-3
}

TEST(Mask, GivesSinglePrecisionAndDualNumbersTheSame) {
  Random random(403);
  const std::vector<Vec3d> points = some_points(random, 40);
  const Mask mask(points, some_values(random, points.size()), kWidth);
  const Vec3d center = random.in_box(1);
  const auto in_float = detail::view_of<float>(mask, center);
  const auto in_double = detail::view_of<double>(mask, center);
  for (int i = 0; i < 3000; ++i) {
    const Vec3d x = random.in_box(1.2);
    const MaskValue<double> m = mask.at(x);
    const MaskValue<float> f = detail::evaluate_mask(in_float, Vec3f(x - center));
    EXPECT_NEAR(m.value, static_cast<double>(f.value), 1e-5);
    EXPECT_LT(norm(m.gradient - Vec3d(f.gradient)) * kWidth, 2e-4);
    const MaskValue<Dual> d = detail::evaluate_mask(in_double, test::variables(x - center));
    EXPECT_NEAR(d.value.v, m.value, 1e-12);
    EXPECT_LT(norm(d.value.g - m.gradient) * kWidth, 1e-10);
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(detail::evaluate_mask(in_float, Vec3f{nan, 1e30F, -1e30F}).value, 1);
}

// All motions with all regions, places in the border.
TEST(Mask, LeavesEveryFieldDivergenceFree) {
  Random random(404);
  double worst = 0;
  int counted = 0;
  for (int round = 0; round < 12; ++round) {
    const std::vector<Vec3d> points = some_points(random, 20);
    const Mask mask(points, some_values(random, points.size()), kWidth);
    const Vec3d center = random.in_box(0.3);
    const auto view = detail::view_of<double>(mask, center);
    for (const Motion& motion : test::random_motions(random)) {
      for (const Region& region : test::random_regions(random)) {
        const Thresholds<double> thresholds = test::random_thresholds(random);
        const Vec3d offset = random.in_box(0.5);
        const Dual t(random.uniform(0, 1));
        std::visit(
            [&](const auto& m, const auto& r) {
              if constexpr (!std::is_same_v<std::decay_t<decltype(m)>, CustomMotion> &&
                            !std::is_same_v<std::decay_t<decltype(r)>, CustomRegion>) {
                for (int i = 0; i < 20; ++i) {
                  const Vec3<Dual> d = test::variables(random.in_box(1));
                  const MaskValue<Dual> value = detail::evaluate_mask(view, d);
                  if (!(value.value.v > 0 && value.value.v < 1)) continue;
                  const Vec3<Dual> v = masked_velocity_where(evaluate(r, d, t), m, thresholds, d, value, offset);
                  const double size = test::jacobian_size(v);
                  if (!(size > 0)) continue;
                  ++counted;
                  worst = std::fmax(worst, std::abs(test::divergence(v)) / std::fmax(size, 1.0));
                }
              }
            },
            motion, region);
      }
    }
  }
  EXPECT_GT(counted, 1500);
  EXPECT_LT(worst, 1e-12);  // rounding
}

TEST(Mask, DependsOnOnePointOfEachCell) {
  Random random(405);
  const std::vector<Vec3d> points = some_points(random, 20000);
  const std::vector<double> values = some_values(random, points.size());
  const std::vector<std::uint32_t> representative = representative_points(points, values, 0.8);
  EXPECT_LT(representative.size(), points.size() / 2);
  std::vector<Vec3d> fewer;
  std::vector<double> theirs;
  for (const std::uint32_t i : representative) {
    fewer.push_back(points[i]);
    theirs.push_back(values[i]);
  }
  EXPECT_EQ(Mask(points, values, 0.8, 1), Mask(fewer, theirs, 0.8, 2));
  for (double& value : theirs) value *= 0.5;
  EXPECT_FALSE(Mask(points, values, 0.8) == Mask(fewer, theirs, 0.8));
}

// Floats put a point on a border of cells into either.
TEST(Mask, HoldsPointsOnTheBordersOfItsCells) {
  Random random(406);
  const double cell = kWidth / 8;
  std::vector<Vec3d> points;
  for (int i = 0; i < 200; ++i) {
    Vec3d p = random.in_box(0.8);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_on_border = (i >> axis & 1) != 0;
      if (is_on_border) p[axis] = std::round(p[axis] / cell) * cell * (1 + 1e-8 * (i % 3 - 1));
    }
    points.push_back(p);
  }
  for (const Vec3d& p : points) {
    const Mask mask(std::vector<Vec3d>{p}, {}, kWidth);
    EXPECT_TRUE(mask.holds(p));
    for (int i = 0; i < 10; ++i) {
      const Vec3d center = random.in_box(2);
      const auto view = detail::view_of<float>(mask.grid(), center);
      const MaskValue<float> m = detail::evaluate_mask(view, Vec3<float>(p - center));
      EXPECT_EQ(m.value, 0) << p.x << ' ' << p.y << ' ' << p.z;
      EXPECT_EQ(m.gradient, (Vec3<float>{0, 0, 0}));
    }
  }
  std::vector<std::uint32_t> representative = representative_points(points, {}, kWidth);
  std::vector<Vec3d> fewer;
  for (const std::uint32_t i : representative) fewer.push_back(points[i]);
  EXPECT_EQ(Mask(points, {}, kWidth), Mask(fewer, {}, kWidth));
}

TEST(Mask, RefusesWhatMakesNone) {
  const std::vector<Vec3d> points{{0, 0, 0}, {1, 0, 0}};
  EXPECT_THROW(Mask({}, {}, 1), InvalidInput);
  EXPECT_THROW(Mask(points, {}, 0), InvalidInput);
  EXPECT_THROW(Mask(points, std::vector<double>{1}, 1), InvalidInput);
  EXPECT_THROW(Mask(points, std::vector<double>{1, 1.5}, 1), InvalidInput);
  const std::vector<Vec3d> far{{1e9, 0, 0}};
  EXPECT_THROW(Mask(far, {}, 1e-9), InvalidInput);
  const std::vector<Vec3d> apart{{0, 0, 0}, {1, 1, 1}};
  EXPECT_THROW(Mask(apart, {}, 1e-3), InvalidInput);
  EXPECT_NO_THROW(Mask(apart, {}, 3e-2));
}

TEST(Mask, NamesAWidthThatWorks) {
  for (const double length : {1.0, 100.0, 3000.0, 77777.0}) {
    const std::vector<Vec3d> apart{{0, 0, 0}, {length, 1, 1}};
    for (const double width : {1e-3, 1e-6}) {
      try {
        Mask(apart, {}, width);
        FAIL() << length;
      } catch (const InvalidInput& error) {
        const std::string message = error.what();
        const std::string words = "at least ";
        const std::size_t at = message.find(words);
        ASSERT_NE(at, std::string::npos) << message;
        EXPECT_NO_THROW(Mask(apart, {}, std::stod(message.substr(at + words.size())))) << message;
      }
    }
  }
}

}  // namespace
}  // namespace knead::mask_test
