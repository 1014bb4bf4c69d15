// The weights of all falloffs.
#include "knead/field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random_fields.h"

namespace knead::blend_test {
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

// 1 - b for the Bernstein polynomial b of this degree whose first three coefficients are 0 and whose others are 1.
double complement_of(int degree, double s) {
  double sum = 0;
  double binomial = 1;
  for (int i = 0; i < 3; ++i) {
    sum += binomial * std::pow(s, i) * std::pow(1 - s, degree - i);
    binomial *= static_cast<double>(degree - i) / (i + 1);
  }
  return sum;
}

TEST(Falloff, IsTheBernsteinPolynomialOfItsDegree) {
  test::Random random(13);
  for (int falloff = kMinFalloff; falloff <= kGreatestFalloff; ++falloff) {
    for (int i = 0; i < 1000; ++i) {
      Thresholds<double> t = test::random_thresholds(random);
      t.falloff = falloff;
      const double s = random.uniform(0, 1);
      const double r = t.inner + s * (t.outer - t.inner);
      EXPECT_NEAR(blend_weight(r, t).value, std::pow(complement_of(falloff, s), falloff == 3 ? 3 : 2), 1e-14)
          << falloff;
      const double h = 1e-6;
      const double slope = (blend_weight(r + h, t).value - blend_weight(r - h, t).value) / (2 * h);
      EXPECT_NEAR(blend_weight(r, t).derivative, slope, 2e-7) << falloff;
    }
  }
}

// dw/dr is 0 at both thresholds and of second order beside them, so it has a derivative there: 0.
TEST(Falloff, IsSmoothAtBothThresholds) {
  for (int falloff = kMinFalloff; falloff <= kGreatestFalloff; ++falloff) {
    const Thresholds<double> t{0, 1, falloff};
    for (const double r : {-1.0, 0.0}) {
      EXPECT_EQ(blend_weight(r, t).value, 1) << falloff;
      EXPECT_EQ(blend_weight(r, t).derivative, 0) << falloff;
    }
    for (const double r : {1.0, 2.0}) {
      EXPECT_EQ(blend_weight(r, t).value, 0) << falloff;
      EXPECT_EQ(blend_weight(r, t).derivative, 0) << falloff;
    }
    for (const double h : {1e-3, 1e-4, 1e-5}) {
      EXPECT_LT(std::abs(blend_weight(h, t).derivative), 250 * h * h) << falloff;
      EXPECT_LT(std::abs(blend_weight(1 - h, t).derivative), 250 * h * h) << falloff;
    }
  }
}

TEST(Falloff, FallsNearerToTheInnerRegionForAGreaterDegree) {
  for (const double r : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    double before = 1;
    for (int falloff = kMinFalloff; falloff <= kGreatestFalloff; ++falloff) {
      const double w = blend_weight(r, Thresholds<double>{0, 1, falloff}).value;
      EXPECT_LT(w, before) << falloff << " at " << r;
      before = w;
    }
  }
}

TEST(Falloff, HasTheFactsThatAreKnownOfIt) {
  for (int falloff = kMinFalloff; falloff <= kGreatestFalloff; ++falloff) {
    const FalloffFacts& facts = falloff_facts(falloff);
    const Thresholds<double> t{0, 1, falloff};
    EXPECT_NEAR(blend_weight(facts.half, t).value, 0.5, 3e-15) << falloff;
    double slope = 0;
    double curvature = 0;
    constexpr int kPlaces = 20'000;
    for (int i = 1; i <= kPlaces; ++i) {
      const double here = blend_weight(static_cast<double>(i) / kPlaces, t).derivative;
      const double before = blend_weight(static_cast<double>(i - 1) / kPlaces, t).derivative;
      slope = std::fmax(slope, -here);
      curvature = std::fmax(curvature, std::abs(here - before) * kPlaces);
    }
    EXPECT_LT(slope, facts.slope) << falloff;
    EXPECT_LT(curvature, facts.curvature) << falloff;
    EXPECT_GT(slope, 0.999 * facts.slope) << falloff;
    EXPECT_GT(curvature, 0.999 * facts.curvature) << falloff;
  }
}

// s(c) = 0.4867502159528536 is where w = 1/2: the bend's default fraction (method, errata).
TEST(Blend, IsOneHalfAtTheBendsDefaultFraction) {
  EXPECT_NEAR(blend_weight(0.4867502159528536, Thresholds<double>{0, 1}).value, 0.5, 1e-15);
  EXPECT_NEAR(blend_weight(0.386, Thresholds<double>{0, 1}).value, 0.70, 0.005);
  EXPECT_NEAR(blend_weight(0.614, Thresholds<double>{0, 1}).value, 0.25, 0.005);
}

}  // namespace
}  // namespace knead::blend_test
