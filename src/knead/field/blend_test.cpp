#include "knead/field/blend.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random_fields.h"

namespace knead {
namespace {

// b as the paper writes it: a Bezier curve of degree 4 with the weights 0, 0, 0, 1, 1 (Eq. 5).
double bernstein_blend(double s) { return 4 * s * s * s * (1 - s) + s * s * s * s; }

TEST(Blend, IsTheSquareOfThePapersBlendSubtractedFromOne) {
  test::Random random(11);
  for (int i = 0; i < 1000; ++i) {
    const Thresholds<double> t = test::random_thresholds(random);
    const double s = random.uniform(0, 1);
    const double expected = std::pow(1 - bernstein_blend(s), 2);
    EXPECT_NEAR(blend_weight(t.inner + s * (t.outer - t.inner), t).value, expected, 4e-15);
  }
}

TEST(Blend, IsExactlyOneInsideAndExactlyZeroOutside) {
  const Thresholds<double> t{0.3, 0.7};
  for (const double r : {-5.0, 0.0, 0.3}) {
    EXPECT_EQ(blend_weight(r, t).value, 1.0);
    EXPECT_EQ(blend_weight(r, t).derivative, 0.0);
  }
  for (const double r : {0.7, 0.8, 1e9}) {
    EXPECT_EQ(blend_weight(r, t).value, 0.0);
    EXPECT_EQ(blend_weight(r, t).derivative, 0.0);
  }
}

TEST(Blend, DerivativeIsThatOfTheValue) {
  test::Random random(12);
  for (int i = 0; i < 1000; ++i) {
    const Thresholds<double> t = test::random_thresholds(random);
    const double r = random.uniform(t.inner, t.outer);
    const double h = 1e-6;
    const double slope = (blend_weight(r + h, t).value - blend_weight(r - h, t).value) / (2 * h);
    // Central differences: h^2 times the third derivative, plus rounding / h.
    EXPECT_NEAR(blend_weight(r, t).derivative, slope, 1e-7);
  }
}

// Near s = 1 the weight is about 36 (1 - s)^4: no cancellation.
TEST(Blend, KeepsItsRelativeAccuracyNearTheOuterThreshold) {
  const Thresholds<double> t{0, 1};
  for (const double rest : {1e-2, 1e-4, 1e-6}) {
    const double s = 1 - rest;
    const double exact_rest = 1 - s;
    const double leading = 36 * std::pow(exact_rest, 4);
    EXPECT_NEAR(blend_weight(s, t).value / leading, 1.0, 3 * rest);
  }
}

// s(c) = 0.4867502159528536 is where w = 1/2: the bend's default fraction (method, errata).
TEST(Blend, IsOneHalfAtTheBendsDefaultFraction) {
  EXPECT_NEAR(blend_weight(0.4867502159528536, Thresholds<double>{0, 1}).value, 0.5, 1e-15);
  EXPECT_NEAR(blend_weight(0.386, Thresholds<double>{0, 1}).value, 0.70, 0.005);
  EXPECT_NEAR(blend_weight(0.614, Thresholds<double>{0, 1}).value, 0.25, 0.005);
}

}  // namespace
}  // namespace knead
