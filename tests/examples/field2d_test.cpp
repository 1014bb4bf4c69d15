#include "field2d.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/dual.h"
#include "support/random_fields.h"

namespace knead::field2d_test {
namespace {

using test::Dual;
using test::Random;

Vec2<Dual> plane_variables(double x, double y) { return {Dual(x, {1, 0, 0}), Dual(y, {0, 1, 0})}; }

template <class M>
void expect_field_properties(const M& motion, Random& random) {
  for (const DiscRegion region : {DiscRegion::distance, DiscRegion::squared_distance}) {
    const Thresholds<double> thresholds = test::random_thresholds(random);
    for (int i = 0; i < 50; ++i) {
      const Vec2<Dual> d = plane_variables(random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2));
      const Field2dValue<Dual> value = evaluate_2d(motion, region, thresholds, d);
      const double size = 1 + norm(value.velocity.x.g) + norm(value.velocity.y.g);
      EXPECT_LT(std::abs(value.velocity.x.g.x + value.velocity.y.g.y) / size, 1e-13);  // div v = 0
      EXPECT_NEAR(value.velocity.x.v, -value.potential.g.y, 1e-12);                    // v = (-p_y, p_x)
      EXPECT_NEAR(value.velocity.y.v, value.potential.g.x, 1e-12);
    }
  }
}

TEST(Field2d, IsTheCoGradientOfItsPotentialAndDivergenceFree) {
  Random random(51);
  for (int i = 0; i < 100; ++i) {
    expect_field_properties(Translation2d{{random.uniform(-1, 1), random.uniform(-1, 1)}}, random);
    expect_field_properties(Rotation2d{random.uniform(-2, 2)}, random);
  }
}

// The paper's own example: r = x^2 + y^2, ri = 1, ro = 4: constant in the unit circle, zero beyond radius 2.
TEST(Field2d, IsConstantInsideAndZeroOutsideInThePapersExample) {
  const Translation2d motion{{0.6, -0.8}};
  const Thresholds<double> thresholds{1, 4};
  const auto at = [&](double x, double y) {
    return evaluate_2d(motion, DiscRegion::squared_distance, thresholds, Vec2<double>{x, y}).velocity;
  };
  EXPECT_EQ(at(0.3, 0.9).x, 0.6);
  EXPECT_EQ(at(0.3, 0.9).y, -0.8);
  EXPECT_EQ(at(1.5, 1.4).x, 0.0);
  EXPECT_EQ(at(1.5, 1.4).y, 0.0);
  const double speed = std::hypot(at(1.2, 0.5).x, at(1.2, 0.5).y);
  EXPECT_GT(speed, 0.01);
  EXPECT_LT(speed, 2.0);
}

}  // namespace
}  // namespace knead::field2d_test
