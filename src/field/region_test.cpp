// Region fields: gradients, exact zeros and definitions.
#include "knead/region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/dual.h"
#include "support/random_fields.h"

namespace knead::region_test {
namespace {

using test::Dual;
using test::Random;

TEST(Region, GradientIsThatOfTheValue) {
  Random random(41);
  for (int round = 0; round < 200; ++round) {
    for (const Region& region : test::random_regions(random)) {
      std::visit(
          [&](const auto& r) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(r)>, CustomRegion>) {
              const RegionValue<Dual> value = evaluate(r, test::variables(random.in_box(1.5)), Dual(0.7));
              // The gradient as computed, against the value's derivative.
              EXPECT_LT(norm(value.value.g - test::values(value.gradient)), 1e-10);
            }
          },
          region);
    }
  }
}

TEST(Region, OfPointsIsOneLipschitz) {
  Random random(42);
  for (int i = 0; i < 2000; ++i) {
    const PointSet<double> set = test::random_point_set(random, false);
    EXPECT_LE(norm(evaluate(set, random.in_box(2), 0.0).gradient), 1 + 1e-12);
  }
}

TEST(Region, IsExactlyZeroOnEveryElement) {
  Random random(43);
  for (int i = 0; i < 200; ++i) {
    const PointSet<double> set = test::random_point_set(random, i % 2 == 0);
    for (const Vec3d& p : set.points) EXPECT_EQ(evaluate(set, p, 0.0).value, 0.0);
    for (const auto& curve : set.curves) {
      for (const Vec3d& p : curve) EXPECT_EQ(evaluate(set, p, 0.0).value, 0.0);
    }
  }
}

TEST(PointSet, ReadsAsItsDefinition) {
  Random random(44);
  for (int i = 0; i < 500; ++i) {
    const PointSet<double> set = test::random_point_set(random, false);
    const Vec3d x = random.in_box(2);
    double sum = 0;
    for (const Vec3d& p : set.points) sum += std::pow(norm(x - p), -set.exponent);
    const double expected = std::pow(sum, -1.0 / set.exponent);
    EXPECT_NEAR(evaluate(set, x, 0.0).value, expected, 1e-13 * (1 + expected));
  }
}

// By composite Simpson quadrature of |x - y|^-5 along the polyline.
TEST(Curve, ReadsAsItsIntegral) {
  Random random(45);
  for (int i = 0; i < 300; ++i) {
    PointSet<double> set = test::random_point_set(random, true);
    set.points.clear();
    set.curves.resize(1);
    const auto& curve = set.curves[0];
    const Vec3d x = random.in_box(1.5);
    const double distance = std::sqrt(squared_distance_to_curve(x, curve));
    if (distance < 0.05) continue;
    double integral = 0;
    for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
      const int pieces = 2000;
      const Vec3d edge = curve[k + 1] - curve[k];
      for (int j = 0; j <= pieces; ++j) {
        const double weight = (j == 0 || j == pieces) ? 1 : (j % 2 == 1 ? 4 : 2);
        integral += weight / 3 / pieces * norm(edge) * std::pow(norm(x - curve[k] - edge * (double(j) / pieces)), -5);
      }
    }
    const double expected = std::pow(0.75 * integral, -0.25);
    EXPECT_NEAR(evaluate(set, x, 0.0).value / expected, 1, 1e-6) << "distance " << distance;
  }
}

PointSet<double> circle(int pieces) {
  PointSet<double> set;
  set.curves.emplace_back();
  for (int i = 0; i <= 4 * 64; i += 4 * 64 / pieces) {
    const double angle = 2 * std::numbers::pi * i / (4 * 64);
    set.curves[0].push_back({std::cos(angle), std::sin(angle), 0});
  }
  return set;
}

// Cutting the edges of a polyline changes nothing; a finer polygon of the same circle changes little.
TEST(Curve, DoesNotDependOnHowFinelyItIsCut) {
  Random random(46);
  for (int i = 0; i < 200; ++i) {
    PointSet<double> set = test::random_point_set(random, true);
    PointSet<double> fine = set;
    for (auto& curve : fine.curves) {
      std::vector<Vec3d> cut;
      for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
        for (int j = 0; j < 7; ++j) cut.push_back(curve[k] + (curve[k + 1] - curve[k]) * (j / 7.0));
      }
      cut.push_back(curve.back());
      curve = cut;
    }
    const Vec3d x = random.in_box(1.5);
    EXPECT_NEAR(evaluate(fine, x, 0.0).value / evaluate(set, x, 0.0).value, 1, 1e-11);
  }
  const Vec3d x{1.3, 0.2, 0.25};
  const double r16 = evaluate(circle(16), x, 0.0).value;
  const double r64 = evaluate(circle(64), x, 0.0).value;
  const double r256 = evaluate(circle(256), x, 0.0).value;
  EXPECT_NEAR(r64, r256, 1e-3);
  EXPECT_NEAR(r16, r256, 2e-2);
}

// Method, section 2: next to a straight curve r is the distance, 1.19 times it beside an end, 1.52 beyond one.
TEST(Curve, ReadsAsTheMethodSaysNearAStraightLine) {
  PointSet<double> line;
  line.curves = {{{-50, 0, 0}, {50, 0, 0}}};
  const auto ratio = [&](const Vec3d& x, double distance) { return evaluate(line, x, 0.0).value / distance; };
  EXPECT_NEAR(ratio({0, 0.1, 0}, 0.1), 1.0, 1e-6);
  EXPECT_NEAR(ratio({50, 0.1, 0}, 0.1), 1.19, 0.005);
  EXPECT_NEAR(ratio({50.1, 0, 0}, 0.1), 1.52, 0.005);
}

// Straight beyond an end the usual closed form cancels; this one must stay smooth down to tiny offsets from the line.
TEST(Curve, DoesNotCancelNearTheLineBeyondAnEnd) {
  PointSet<double> line;
  line.curves = {{{0, 0, 0}, {1, 0, 0}}};
  const double on_line = evaluate(line, Vec3d{1.4, 0, 0}, 0.0).value;
  for (const double offset : {1e-3, 1e-5, 1e-7, 1e-9, 1e-12}) {
    const RegionValue<double> near = evaluate(line, Vec3d{1.4, offset, 0}, 0.0);
    EXPECT_NEAR(near.value, on_line, 3 * offset * offset + 1e-14);
    EXPECT_NEAR(near.gradient.y / offset, evaluate(line, Vec3d{1.4, 1e-3, 0}, 0.0).gradient.y / 1e-3, 1e-4);
  }
}

TEST(Capsule, IsTheDistanceToItsSegment) {
  Random random(47);
  for (int i = 0; i < 500; ++i) {
    const Capsule<double> capsule{random.in_box(0.7)};
    const Vec3d d = random.in_box(1.5);
    double least = 1e9;
    for (int k = -1000; k <= 1000; ++k) least = std::fmin(least, norm(d - capsule.half_axis * (k / 1000.0)));
    EXPECT_NEAR(evaluate(capsule, d, 0.0).value, least, 1e-3);
    EXPECT_LE(evaluate(capsule, d, 0.0).value, least + 1e-14);
  }
  EXPECT_EQ(evaluate(Capsule<double>{{0, 0, 0}}, Vec3d{3, 4, 0}, 0.0).value, 5.0);
}

TEST(HalfSpace, TurnsItsNormalAboutTheAxis) {
  const HalfSpace<double> region{{1, 0, 0}, {0, 0, 1}, std::numbers::pi / 2};
  EXPECT_LT(norm(normal_at(region, 0.0) - Vec3d{1, 0, 0}), 1e-15);
  EXPECT_LT(norm(normal_at(region, 1.0) - Vec3d{0, 1, 0}), 1e-15);
  EXPECT_LT(norm(normal_at(region, 0.5) - Vec3d{std::sqrt(0.5), std::sqrt(0.5), 0}), 1e-15);
}

}  // namespace
}  // namespace knead::region_test
