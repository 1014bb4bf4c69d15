// The properties of the wide falloff: what the paper's blend promises, and where the flow comes back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "field/dual.h"
#include "knead/field.h"
#include "support/random_fields.h"

namespace knead::wide_test {
namespace {

using test::Random;

Thresholds<double> wide(double bump, double outer, double core = 0) { return {core * bump, outer, kWideFalloff, bump}; }

// Without a core and with one, with the flow back near and far.
std::vector<Thresholds<double>> cases() {
  return {wide(1, 4),     wide(0.35, 1.4),  wide(1, 1.1),    wide(1e-3, 0.5),
          wide(300, 900), wide(1, 4, 0.01), wide(1, 4, 0.5), wide(0.2, 0.3, 0.8)};
}

// v across the motion on the plane through the centre, for a translation by 1.
double profile(double r, const Thresholds<double>& t) {
  const Weight<double> w = blend_weight(r, t);
  return w.value + 0.5 * r * w.derivative;
}

TEST(Wide, IsTheFormulaOfTheTwoBrackets) {
  for (const Thresholds<double>& t : cases()) {
    if (t.inner > 0) continue;
    const double a2 = t.bump * t.bump;
    const double o2 = t.outer * t.outer;
    for (int i = 1; i < 200; ++i) {
      const double r = t.outer * i / 180;
      const double in = std::pow(std::max(1 - r * r / a2, 0.0), 3);
      const double out = std::pow(std::max(1 - r * r / o2, 0.0), 3);
      const double expected = (out - in) * a2 * o2 / (3 * r * r * (o2 - a2));
      // The difference of the brackets cancels for small r.
      EXPECT_NEAR(blend_weight(r, t).value, expected, 1e-15 * a2 * o2 / (r * r * (o2 - a2)) + 1e-14);
    }
  }
}

TEST(Wide, IsExactlyOneAtTheCentreAndInTheCoreAndExactlyZeroOutside) {
  for (const Thresholds<double>& t : cases()) {
    const Thresholds<float> single(t);
    for (const double r : {0.0, 0.5 * t.inner, t.inner}) {
      EXPECT_EQ(blend_weight(r, t).value, 1.0);
      EXPECT_EQ(blend_weight(r, t).derivative, 0.0);
    }
    for (const double factor : {1.0, 1.0 + 1e-6, 1.5, 1e9}) {
      EXPECT_EQ(blend_weight(factor * t.outer, t).value, 0.0);
      EXPECT_EQ(blend_weight(factor * t.outer, t).derivative, 0.0);
      EXPECT_EQ(blend_weight(static_cast<float>(factor) * single.outer, single).value, 0.0F);
      EXPECT_EQ(blend_weight(static_cast<float>(factor) * single.outer, single).derivative, 0.0F);
    }
  }
}

TEST(Wide, NothingFlowsThroughThePlaneAcrossTheMotion) {
  constexpr int kSteps = 20000;
  for (const Thresholds<double>& t : cases()) {
    double flux = 0;
    double moved = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double r = t.outer * (i + 0.5) / kSteps;
      flux += profile(r, t) * r;
      moved += std::abs(profile(r, t)) * r;
    }
    EXPECT_LT(std::abs(flux), 1e-3 * moved);  // where the bump is a few steps wide
    EXPECT_LE(profile(0.99 * t.bump, t), 0.01);
    EXPECT_LT(profile(1.01 * t.bump, t), 0) << "it flows back right outside the bump";
  }
}

// The flow back is so much weaker than the bump as its disc is greater.
TEST(Wide, TheFlowBackIsASixteenthForFourRadii) {
  EXPECT_NEAR(profile(0, wide(1, 4)), 1, 1e-15);
  double back = 0;
  for (int i = 0; i < 1000; ++i) back = std::min(back, profile(i * 0.004, wide(1, 4)));
  EXPECT_NEAR(back, -1.0 / 15, 0.01);
}

// w, w' and w'' are continuous: the slopes on both sides of each place agree.
TEST(Wide, HasTwoContinuousDerivatives) {
  for (const Thresholds<double>& t : cases()) {
    const double size = t.inner > 0 ? std::min(t.inner, t.bump - t.inner) : t.bump;
    const double h = 1e-6 * size;
    for (const double r : {t.inner, t.bump, t.outer, 0.3 * t.bump, 0.5 * (t.bump + t.outer)}) {
      if (r < 3 * h) continue;
      const double slope = (blend_weight(r + h, t).value - blend_weight(r - h, t).value) / (2 * h);
      EXPECT_NEAR(blend_weight(r, t).derivative * size, slope * size, 1e-8);
      const auto curvature = [&](double a, double b) {
        return (blend_weight(b, t).derivative - blend_weight(a, t).derivative) / (b - a) * size * size;
      };
      EXPECT_NEAR(curvature(r - 2 * h, r - h), curvature(r + h, r + 2 * h), 1e-3) << r;
    }
  }
}

TEST(Wide, EveryMotionOfAWideBallIsFreeOfDivergence) {
  Random random(410);
  for (const Thresholds<double>& t : cases()) {
    for (int i = 0; i < 50; ++i) {
      const Vec3d d = random.unit() * (t.outer * random.uniform(0, 1.02));
      const auto divergence = [&](const auto& motion) {
        const Vec3<Dual> v = velocity(motion, Ball<double>{}, t, variables(d), Dual(0));
        const double size = std::abs(v.x.g.x) + std::abs(v.y.g.y) + std::abs(v.z.g.z);
        return std::abs(v.x.g.x + v.y.g.y + v.z.g.z) / (size + 1e-6 / t.bump);
      };
      const Vec3d axis = random.unit();
      EXPECT_LT(divergence(Translation<double>{random.unit()}), 1e-9);
      EXPECT_LT(divergence(Rotation<double>{axis, 1, random.uniform(0, 1), RotationGauge::radial}), 1e-9);
      EXPECT_LT(divergence(Strain<double>{outer_product(axis, axis) * 1.5 + Mat3d{} * -0.5}), 1e-9);
    }
  }
}

TEST(Wide, FloatAgreesWithDouble) {
  for (const Thresholds<double>& t : cases()) {
    const Thresholds<float> single(t);
    for (int i = 0; i < 2000; ++i) {
      const double r = t.outer * i / 1900;
      const Weight<double> w = blend_weight(r, t);
      const Weight<float> found = blend_weight(static_cast<float>(r), single);
      EXPECT_NEAR(found.value, w.value, 4e-6);
      EXPECT_NEAR(static_cast<double>(found.derivative) * (t.bump - t.inner), w.derivative * (t.bump - t.inner), 2e-5);
    }
  }
}

}  // namespace
}  // namespace knead::wide_test
