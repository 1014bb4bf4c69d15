// What the mathematics says is constant along path lines (method, section 3, "Exact facts").
#include <gtest/gtest.h>

#include <cmath>

#include "knead/vec.h"
#include "support/random_segments.h"

namespace knead::invariants_test {
namespace {

using test::moved;
using test::precisely;
using test::Random;

// psi = rho^2 (1 - w(|d|)) for a ball swept along a straight line.
TEST(Invariants, PsiIsConstantAlongPathLinesOfASweptBall) {
  Random random(91);
  for (int round = 0; round < 20; ++round) {
    const Vec3d by = random.in_box(1);
    const Vec3d c = random.in_box(0.5);
    const Thresholds<double> thresholds = test::random_thresholds(random);
    const Flow flow{{test::translating(Ball<double>{}, c, by, thresholds)}};
    const auto psi = [&](const Vec3d& d) {
      const Vec3d axis = normalized(by);
      const double rho2 = norm2(d - axis * dot(axis, d));
      return rho2 * (1 - blend_weight(norm(d), thresholds).value);
    };
    const auto points = test::random_points(random, 200);
    const auto after = moved(flow, points, precisely(1e-11));
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(psi(after[i] - c - by), psi(points[i] - c), 1e-8);
    }
  }
}

TEST(Invariants, PsiIsConstantForEveryFalloff) {
  Random random(94);
  for (const int falloff : test::kOtherFalloffs) {
    Thresholds<double> thresholds = test::random_thresholds(random);
    test::set_falloff(thresholds, falloff);
    const Vec3d by = random.in_box(1);
    const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, by, thresholds)}};
    const auto psi = [&](const Vec3d& d) {
      const Vec3d axis = normalized(by);
      return norm2(d - axis * dot(axis, d)) * (1 - blend_weight(norm(d), thresholds).value);
    };
    const auto points = test::random_points(random, 200);
    const auto after = moved(flow, points, precisely(1e-11));
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(psi(after[i] - by), psi(points[i]), 1e-8) << falloff;
  }
}

// p = (1-b) e and q = (1-b) f of a static field: here a rotation with e = a.d, f = |a x d|^2 in a capsule and a
// half-space.
TEST(Invariants, PAndQAreConstantAlongPathLinesOfAStaticField) {
  Random random(92);
  const std::vector<Region> regions = {Capsule<double>{{0.3, 0.1, 0}}, HalfSpace<double>{random.unit()},
                                       Ball<double>{}};
  for (const Region& region : regions) {
    for (int round = 0; round < 10; ++round) {
      const Vec3d a = random.unit();
      const Thresholds<double> thresholds = test::random_thresholds(random);
      const Segment segment = test::resting(Rotation<double>{a, 1.5, 1}, region, {0, 0, 0}, thresholds);
      const auto p_and_q = [&](const Vec3d& d) {
        const double root = std::sqrt(blend_weight(region_value(segment.fields[0], d).value, thresholds).value);
        return std::pair{root * dot(a, d), root * norm2(cross(a, d))};
      };
      const auto points = test::random_points(random, 100);
      const auto after = moved(Flow{{segment}}, points, precisely(1e-11));
      for (std::size_t i = 0; i < points.size(); ++i) {
        const auto [p0, q0] = p_and_q(points[i]);
        const auto [p1, q1] = p_and_q(after[i]);
        EXPECT_NEAR(p1, p0, 1e-8);
        EXPECT_NEAR(q1, q0, 1e-8);
      }
    }
  }
}

// The flow map's Jacobian by central differences of fourth order; its determinant is 1.
TEST(Invariants, TheFlowMapKeepsVolume) {
  Random random(93);
  int checked = 0;
  for (const int falloff : {4, 4, 4, 4, 4, 4, 3, 5, 6, 7, kWideFalloff}) {
    for (const auto& [name, segment] : test::random_segments(random, falloff)) {
      if (name.find("capsule") != std::string::npos) continue;  // v is only C0 on the planes through its ends
      for (const Vec3d& x : test::random_points(random, 12, 0.8)) {
        const double h = 2e-4;
        std::vector<Vec3d> stencil;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (const double offset : {-2 * h, -h, h, 2 * h}) {
            Vec3d p = x;
            p[axis] += offset;
            stencil.push_back(p);
          }
        }
        const auto m = moved(Flow{{segment}}, stencil, precisely(1e-13));
        const auto column = [&](std::size_t k) {
          return (m[4 * k] - m[4 * k + 1] * 8.0 + m[4 * k + 2] * 8.0 - m[4 * k + 3]) / (12 * h);
        };
        const Mat3d transposed{column(0), column(1), column(2)};
        const double size = row_sum_norm(transposed);
        if (size > 30) continue;  // so strongly stretched that h no longer resolves it
        ++checked;
        // h^2 to h^4 times high derivatives (v is C1 only at ri), and 1e-13/h of the integration, times the stretch.
        EXPECT_NEAR(determinant(transposed), 1, 1e-4 * size * size) << name;
      }
    }
  }
  EXPECT_GT(checked, 500);
}

}  // namespace
}  // namespace knead::invariants_test
