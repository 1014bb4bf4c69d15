// Velocity fields: divergence, continuity, and the values inside and outside.
#include "knead/field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/dual.h"
#include "support/random_fields.h"

namespace knead::field_test {
namespace {

using test::Dual;
using test::Random;

// Calls check(motion, region, thresholds, name) for every motion with every region, `rounds` times with other numbers.
template <class Check>
void for_random_fields(unsigned seed, int rounds, const Check& check) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int round = 0; round < rounds; ++round) {
    for (const Motion& motion : test::random_motions(random)) {
      for (const Region& region : test::random_regions(random)) {
        const Thresholds<double> thresholds = test::random_thresholds(random);
        std::visit(
            [&](const auto& m, const auto& r) {
              if constexpr (!std::is_same_v<std::decay_t<decltype(m)>, CustomMotion> &&
                            !std::is_same_v<std::decay_t<decltype(r)>, CustomRegion>) {
                check(m, r, thresholds, random);
              }
            },
            motion, region);
      }
    }
  }
}

// 40 rounds x 40 fields x 20 positions.
TEST(Velocity, IsDivergenceFreeByDualNumbers) {
  double worst = 0;
  for_random_fields(21, 40, [&](const auto& m, const auto& r, const Thresholds<double>& thresholds, Random& random) {
    const Dual t(random.uniform(0, 1));
    for (int i = 0; i < 20; ++i) {
      const Vec3<Dual> v = velocity(m, r, thresholds, test::variables(random.in_box(1.5)), t);
      const double size = test::jacobian_size(v);
      if (size > 0) worst = std::fmax(worst, std::abs(test::divergence(v)) / std::fmax(size, 1.0));
    }
  });
  EXPECT_LT(worst, 1e-12);
}

TEST(Velocity, IsDivergenceFreeForEveryFalloff) {
  double worst = 0;
  for_random_fields(27, 8, [&](const auto& m, const auto& r, Thresholds<double> thresholds, Random& random) {
    const Dual t(random.uniform(0, 1));
    for (int i = 0; i < 50; ++i) {
      thresholds.falloff = kMinFalloff + i % (kGreatestFalloff - kMinFalloff + 1);
      const Vec3<Dual> v = velocity(m, r, thresholds, test::variables(random.in_box(1.5)), t);
      const double size = test::jacobian_size(v);
      if (size > 0) worst = std::fmax(worst, std::abs(test::divergence(v)) / std::fmax(size, 1.0));
    }
  });
  EXPECT_LT(worst, 1e-12);
}

TEST(Velocity, IsDivergenceFreeByFiniteDifferences) {
  double worst = 0;
  for_random_fields(22, 10, [&](const auto& m, const auto& r, const Thresholds<double>& thresholds, Random& random) {
    const double t = random.uniform(0, 1);
    for (int i = 0; i < 10; ++i) {
      const Vec3d x = random.in_box(1.2);
      const double h = 1e-5;
      double divergence = 0;
      double size = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3d step{0, 0, 0};
        step[axis] = h;
        const Vec3d difference =
            (velocity(m, r, thresholds, x + step, t) - velocity(m, r, thresholds, x - step, t)) / (2 * h);
        divergence += difference[axis];
        size = std::fmax(size, norm(difference));
      }
      worst = std::fmax(worst, std::abs(divergence) / size);
    }
  });
  // h^2 times third derivatives (up to some 1e3 where thresholds are close), and h^-1 times rounding; v is only C1
  // where a difference straddles a threshold, so that the error is then of the order h.
  EXPECT_LT(worst, 2e-4);
}

TEST(Velocity, IsTheInnerMotionInsideAndZeroOutside) {
  for_random_fields(23, 10, [&](const auto& m, const auto& r, const Thresholds<double>& thresholds, Random& random) {
    const double t = random.uniform(0, 1);
    for (int i = 0; i < 30; ++i) {
      const Vec3d d = random.in_box(1.5);
      const double value = evaluate(r, d, t).value;
      const Vec3d v = velocity(m, r, thresholds, d, t);
      if (value <= thresholds.inner) {
        EXPECT_EQ(v, evaluate(m, d).velocity);
      }
      if (value >= thresholds.outer) {
        EXPECT_EQ(v, (Vec3d{0, 0, 0}));
      }
    }
  });
}

TEST(Motion, VelocityIsTheCurlOfThePotentialForEveryGauge) {
  Random random(24);
  for (int round = 0; round < 200; ++round) {
    for (const Motion& motion : test::random_motions(random)) {
      std::visit(
          [&](const auto& m) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(m)>, CustomMotion>) {
              const MotionValue<Dual> value = evaluate(m, test::variables(random.in_box(2)));
              const Vec3d u = test::values(value.velocity);
              EXPECT_LT(norm(test::curl(value.potential) - u), 1e-13 * (1 + norm(u)));
            }
          },
          motion);
    }
  }
}

// Regions that are C2 (the capsule is only piecewise so), with a point on r = threshold found by bisection along a ray.
template <class R>
bool find_threshold(const R& region, double threshold, const Vec3d& a, const Vec3d& b, Vec3d& x) {
  double low = 0;
  double high = 1;
  const auto value = [&](double s) { return evaluate(region, a + (b - a) * s, 0.3).value - threshold; };
  if (value(0) * value(1) >= 0) return false;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (value(low) * value(middle) <= 0 ? high : low) = middle;
  }
  x = a + (b - a) * low;
  return true;
}

// Calls visit(jacobian, scale, thresholds, threshold) where random fields cross their thresholds: the Jacobian at an
// offset along the region's gradient there, and its size nearby. The falloffs take turns where `every_falloff` is set.
// Returns how many places it found. Capsules are left out: their distance is C1 only.
template <class Visit>
int for_random_crossings(unsigned seed, int rounds, bool every_falloff, Visit visit) {
  int found = 0;
  for_random_fields(seed, rounds, [&](const auto& m, const auto& r, Thresholds<double> thresholds, Random& random) {
    using R = std::decay_t<decltype(r)>;
    if constexpr (!std::is_same_v<R, Capsule<double>>) {
      if (every_falloff) thresholds.falloff = kMinFalloff + found % (kGreatestFalloff - kMinFalloff + 1);
      for (const double threshold : {thresholds.inner, thresholds.outer}) {
        Vec3d x;
        if (!find_threshold(r, threshold, random.in_box(1.2), random.in_box(1.2), x)) continue;
        const RegionValue<double> at = evaluate(r, x, 0.3);
        if (norm(at.gradient) < 0.1) continue;
        ++found;
        const Vec3d n = at.gradient / norm(at.gradient);
        const auto jacobian = [&](double offset) {
          return velocity(m, r, thresholds, test::variables(x + n * offset), Dual(0.3));
        };
        const double scale = 1 + test::jacobian_size(jacobian(-0.05)) + test::jacobian_size(jacobian(0.05));
        visit(jacobian, scale, thresholds, threshold);
      }
    }
  });
  return found;
}

// The Jacobian's change over a step of length h across a threshold falls with h: v is C1 there. Its second derivative's
// change falls too at the outer threshold: v is C2 there.
TEST(Velocity, IsC1AcrossTheInnerAndC2AcrossTheOuterThreshold) {
  const auto visit = [](const auto& jacobian, double scale, const Thresholds<double>& thresholds, double threshold) {
    const double h = 1e-6;
    // Measured: at most 4e-4 over these seeds, h times second derivatives of up to some hundreds.
    EXPECT_LT(test::jacobian_difference(jacobian(-h), jacobian(h)) / scale, 2e-3);
    if (threshold == thresholds.outer) {
      const double second_inside = test::jacobian_difference(jacobian(-2 * h), jacobian(-h)) / h;
      EXPECT_LT(second_inside / scale, 0.05);
    }
  };
  EXPECT_GT(for_random_crossings(25, 60, false, visit), 500);
}

// The Jacobian's change over a step across a threshold falls with the step.
TEST(Velocity, IsC1AcrossBothThresholdsForEveryFalloff) {
  const auto visit = [](const auto& jacobian, double scale, const Thresholds<double>& thresholds,
                        double /*threshold*/) {
    for (const double h : {1e-5, 1e-6}) {
      EXPECT_LT(test::jacobian_difference(jacobian(-h), jacobian(h)) / scale, 1e4 * h) << thresholds.falloff;
    }
  };
  EXPECT_GT(for_random_crossings(28, 30, true, visit), 250);
}

TEST(Velocity, InFloatIsThatInDoubleToFloatsAccuracy) {
  double worst = 0;
  for_random_fields(26, 20, [&](const auto& m, const auto& r, const Thresholds<double>& thresholds, Random& random) {
    if constexpr (std::is_same_v<std::decay_t<decltype(r)>, Ball<double>>) {
      const Vec3d d = random.in_box(1.0);
      const Vec3d expected = velocity(m, r, thresholds, d, 0.5);
      using M = std::decay_t<decltype(m)>;
      const auto motion = [&] {
        if constexpr (std::is_same_v<M, Translation<double>>)
          return static_cast<Translation<float>>(m);
        else if constexpr (std::is_same_v<M, Rotation<double>>)
          return static_cast<Rotation<float>>(m);
        else if constexpr (std::is_same_v<M, Twist<double>>)
          return static_cast<Twist<float>>(m);
        else
          return static_cast<Strain<float>>(m);
      }();
      const Vec3f v = velocity(motion, Ball<float>{}, static_cast<Thresholds<float>>(thresholds), Vec3f(d), 0.5F);
      worst = std::fmax(worst, norm(Vec3d(v) - expected) / (1 + norm(expected)));
    }
  });
  EXPECT_LT(worst, 1e-5);  // dw/dr amplifies the rounding of r by up to 2/(outer - inner)
}

TEST(Velocity, OfACustomRegionAndMotionIsThatOfTheBuiltInOnes) {
  const CustomRegion region = custom_region([](const Vec3d& d, double t) { return evaluate(Ball<double>{}, d, t); });
  const Translation<double> translation{{0.3, -0.2, 1.0}, {}, 1};
  const auto motion = std::make_shared<const std::function<MotionValue<double>(const Vec3d&)>>(
      [=](const Vec3d& d) { return evaluate(translation, d); });
  const Field custom{{0, 0, 0}, CustomMotion{motion}, region, {0.2, 0.9}};
  const Field built_in{{0, 0, 0}, translation, Ball<double>{}, {0.2, 0.9}};
  Random random(27);
  for (int i = 0; i < 100; ++i) {
    const Vec3d d = random.in_box(1);
    EXPECT_LT(norm(velocity(custom, d) - velocity(built_in, d)), 2e-15);  // a ball's own form rounds otherwise
  }
}

}  // namespace
}  // namespace knead::field_test
