// The step that raises the least of several linear values.
#include "remesh/vertex_star.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace knead::detail::best_step_test {
namespace {

struct Planes {
  std::vector<double> values;
  std::vector<Vec3d> gradients;

  double least_at(const Vec3d& d) const {
    double least = kInfinity;
    for (std::size_t i = 0; i < values.size(); ++i) least = std::min(least, values[i] + dot(gradients[i], d));
    return least;
  }

  double gain_at(const Vec3d& d, double reach) const { return least_at(d) - norm2(d) / (2 * reach); }
};

Planes random_planes(std::mt19937& random, std::size_t count, double spread) {
  std::normal_distribution<double> normal;
  Planes planes;
  for (std::size_t i = 0; i < count; ++i) {
    planes.values.push_back(spread * normal(random));
    planes.gradients.push_back({normal(random), normal(random), normal(random)});
  }
  return planes;
}

TEST(BestStep, IsNotBeatenByOthers) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const double spread : {0.0, 0.01, 0.1, 1.0}) {
    for (const double reach : {0.05, 1.0, 20.0}) {
      for (const std::size_t count : {1U, 2U, 3U, 4U, 8U, 30U}) {
        const Planes planes = random_planes(random, count, spread);
        const Vec3d best = best_step(planes.values, planes.gradients, reach);
        const double gain = planes.gain_at(best, reach);
        for (int i = 0; i < 1000; ++i) {
          const Vec3d shift = Vec3d{normal(random), normal(random), normal(random)} * (i % 2 == 0 ? 0.01 : 1.0);
          ASSERT_LE(planes.gain_at(best + shift * reach, reach), gain + 2e-4) << spread << " " << reach << " " << count;
        }
      }
    }
  }
}

TEST(BestStep, OfOneValueIsItsGradient) {
  const Vec3d g{1, -2, 3};
  EXPECT_LT(norm(best_step(std::vector<double>{0.3}, std::vector<Vec3d>{g}, 0.5) - g * 0.5), 1e-12);
}

// The gradients of the faces of a cube cancel out; so do equal ones, on which a matrix has no inverse.
TEST(BestStep, StaysWhereNothingRises) {
  const std::vector<Vec3d> gradients{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {1, 0, 0}};
  EXPECT_LT(norm(best_step(std::vector<double>(7, 0.2), gradients, 1)), 1e-4);
  EXPECT_EQ(best_step(std::vector<double>(3, 0.0), std::vector<Vec3d>(3, Vec3d{0, 0, 0}), 1), (Vec3d{0, 0, 0}));
}

TEST(BestStep, RaisesTheLeastNotThoseFarAbove) {
  const std::vector<double> values{0, 10};
  const std::vector<Vec3d> gradients{{1, 0, 0}, {-1, 0, 0}};
  EXPECT_LT(norm(best_step(values, gradients, 1) - Vec3d{1, 0, 0}), 1e-12);
  // At reach 100 they meet half way.
  EXPECT_LT(norm(best_step(values, gradients, 100) - Vec3d{5, 0, 0}), 1e-3);
}

}  // namespace
}  // namespace knead::detail::best_step_test
