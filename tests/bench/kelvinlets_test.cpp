#include "yardsticks.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace knead::bench::kelvinlets_test {
namespace {

std::vector<Vec3d> places(std::size_t count, double reach) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-reach, reach);
  std::vector<Vec3d> points(count);
  for (Vec3d& p : points) {
    for (std::size_t k = 0; k < 3; ++k) p[k] = number(random);
  }
  return points;
}

TEST(Kelvinlet, TheTipGoesAsAsked) {
  const Vec3d tip{0.3, -0.2, 0.5};
  EXPECT_NEAR(norm(kelvinlet(Vec3d{}, tip, 0.7) - tip), 0, 1e-15);
}

TEST(Kelvinlet, StraightAheadItFallsAsOneOverTheDistance) {
  const Vec3d tip{0, 0, 2};
  for (const double z : {0.1, 1.0, std::sqrt(3.0) * 0.7, 40.0}) {
    const Vec3d u = kelvinlet(Vec3d{0, 0, z}, tip, 0.7);
    EXPECT_NEAR(u.z, 2 * 0.7 / std::hypot(z, 0.7), 1e-14) << z;
  }
}

TEST(Kelvinlet, IsFreeOfDivergence) {
  constexpr double kStep = 1e-4;  // central differences: errors of about its square, and 1e-16 / kStep from rounding
  const Vec3d tip{0.3, -0.2, 0.5};
  for (const Vec3d& p : places(100, 3)) {
    double divergence = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3d e;
      e[k] = kStep;
      divergence += (kelvinlet(p + e, tip, 0.7)[k] - kelvinlet(p - e, tip, 0.7)[k]) / (2 * kStep);
    }
    EXPECT_NEAR(divergence, 0, 1e-7);
  }
}

TEST(Kelvinlet, ADisplacementIsTheVelocityOfTheWholePiece) {
  const std::array<Vec3d, 3> path{Vec3d{5, 5, 5}, Vec3d{5, 5, 5.3}, Vec3d{5.2, 5, 5.3}};
  std::vector<Vec3d> points = places(600, 6);  // more than two blocks
  std::vector<Vec3d> expected = points;
  for (Vec3d& p : expected) {
    p += kelvinlet(p - path[0], path[1] - path[0], 0.4);
    p += kelvinlet(p - path[1], path[2] - path[1], 0.4);
  }
  displace_kelvinlet({path, 0.4}, points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(norm(points[i] - expected[i]), 0, 5e-6);  // float, at 20
}

TEST(Kelvinlet, TheTipIsCarriedToThePathsEnd) {
  const std::array<Vec3d, 3> path{Vec3d{5, 5, 5}, Vec3d{5, 5, 9}, Vec3d{7, 5, 9}};
  const KelvinletBrush brush{path, 0.4};
  std::vector<Vec3d> points{path[0]};
  advect_kelvinlet(brush, points, sufficient_steps(brush));
  EXPECT_NEAR(norm(points[0] - path[2]), 0, 1e-5);
}

TEST(Kelvinlet, SufficientStepsAreAccurate) {
  const std::array<Vec3d, 2> path{Vec3d{}, Vec3d{1, 2, -3}};
  const KelvinletBrush brush{path, 0.1 * norm(path[1])};
  EXPECT_EQ(sufficient_steps(brush), 15);
  std::vector<Vec3d> points = places(2000, 3);
  std::vector<Vec3d> expected = points;
  advect_kelvinlet(brush, points, sufficient_steps(brush));
  advect_kelvinlet(brush, expected, 150);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(norm(points[i] - expected[i]), 0, 1e-4 * brush.epsilon) << i;
  }
}

}  // namespace
}  // namespace knead::bench::kelvinlets_test
