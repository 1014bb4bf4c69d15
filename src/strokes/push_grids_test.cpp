// Sums of wide pushes as grids, against the pushes themselves.
#include "strokes/push_grids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "knead/flow.h"

namespace knead::push_grids_test {
namespace {

using detail::PushGrids;

// One push of the wide falloff that moves its place by a vector.
Segment push_of(const Vec3d& place, const Vec3d& vector, double bump, double outer) {
  Field field;
  field.center = place;
  field.motion = Translation<double>{vector};
  field.region = Ball<double>{};
  field.thresholds = {0, outer, kWideFalloff, bump};
  Segment segment;
  segment.fields = {field};
  return segment;
}

// Pushes that fill a disc as a print does. Splines of half the bump soften the sum a little.
TEST(PushGrids, TheirSumIsThatOfThePushes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const double size : {1.0, 1e-3, 1e3}) {
    const double bump = 0.2 * size;
    const double outer = 1.7 * size;
    std::vector<Vec3d> places;
    for (int i = -8; i <= 8; ++i) {
      for (int j = -8; j <= 8; ++j) {
        if (i * i + j * j <= 64) places.push_back(Vec3d{i * 0.4, j * 0.4, 0.02 * i * j} * bump);
      }
    }
    const std::vector<Vec3d> vectors(places.size(), Vec3d{0.01, 0.02, 0.05} * size);
    std::vector<Vec3d> at;
    at.reserve(300);
    for (int i = 0; i < 300; ++i) at.push_back(Vec3d{uniform(random), uniform(random), 0.5 * uniform(random)} * size);
    std::vector<Vec3d> by_grids(at.size());
    const PushGrids pushes(places, bump, outer, 0);
    const std::vector<PotentialGrid> grids = pushes.grids(places, vectors);
    EXPECT_EQ(grids.size(), pushes.count());
    for (const PotentialGrid& grid : grids) {
      Segment segment;
      segment.grid = grid;
      const std::vector<Vec3d> v = velocities(Flow{{segment}}, at, 0);
      for (std::size_t i = 0; i < at.size(); ++i) by_grids[i] += v[i];
    }
    std::vector<Vec3d> by_pushes(at.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
      const std::vector<Vec3d> v = velocities(Flow{{push_of(places[k], vectors[k], bump, outer)}}, at, 0);
      for (std::size_t i = 0; i < at.size(); ++i) by_pushes[i] += v[i];
    }
    double greatest = 0;
    double error = 0;
    double sum2 = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      greatest = std::max(greatest, norm(by_pushes[i]));
      error = std::max(error, norm(by_grids[i] - by_pushes[i]));
      sum2 += norm2(by_grids[i] - by_pushes[i]);
    }
    EXPECT_LT(error, 0.15 * greatest) << size;
    EXPECT_LT(std::sqrt(sum2 / static_cast<double>(at.size())), 0.03 * greatest) << size;
  }
}

// Around a ring, and in a line askew to the axes, grids cover little more than what moves.
TEST(PushGrids, NodesGrowWithTheLengthOfARing) {
  const auto nodes = [](int count, double radius) {
    std::vector<Vec3d> places;
    for (int i = 0; i < count; ++i) {
      const double turn = 6.283185307 * i / count;
      places.push_back(Vec3d{std::cos(turn), std::sin(turn), 0} * radius);
    }
    std::size_t sum = 0;
    const PushGrids pushes(places, 1, 4, 0);
    for (const PotentialGrid& grid : pushes.grids(places, places)) sum += grid.coefficients.size();
    EXPECT_NEAR(pushes.nodes() / static_cast<double>(sum), 1, 0.05);
    return pushes.nodes();
  };
  EXPECT_LT(nodes(2000, 100), 2.5 * nodes(1000, 50));
}

}  // namespace
}  // namespace knead::push_grids_test
