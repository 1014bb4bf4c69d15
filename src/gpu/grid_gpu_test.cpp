// Grids of potentials on the GPU against the CPU.
#include <gtest/gtest.h>

#include "field/grid.h"
#include "support/gpu_fixture.h"
#include "support/random_grids.h"
#include "support/random_segments.h"

namespace knead::grid_gpu_test {
namespace {

using gpu::bits;
using gpu::default_options;
using test::moved;
using test::precisely;
using test::Random;

class GridGpuTest : public gpu::GpuTest {};

// All nodes in use, and some; at rest and changing in time.
std::vector<Segment> grids(Random& random) {
  return {test::random_grid(random), test::random_grid(random, false, 0.1), test::random_grid(random, true),
          test::random_grid(random, true, 0.1)};
}

// The bar is that of all fields: 2e-5 of the box's diagonal.
TEST_F(GridGpuTest, AgreesWithTheReference) {
  Random random(931);
  for (const Segment& grid : grids(random)) {
    const auto points = test::random_points(random, 400);
    const double diagonal = bounding_box(points).diagonal();
    for (const auto& [begin, end] : {std::pair{0.0, 1.0}, std::pair{0.8, 0.3}}) {
      Segment segment = grid;
      segment.begin = begin;
      segment.end = end;
      const Flow flow{{segment}};
      const auto exact = moved(flow, points, precisely(1e-10));
      const double error = test::greatest_distance(on_gpu(flow, points, default_options(diagonal)), exact);
      EXPECT_LT(error / diagonal, 2e-5);
      EXPECT_GT(test::greatest_distance(exact, points) / diagonal, 0.005);
    }
  }
}

// Far below what float resolves: the formulas are the same.
TEST_F(GridGpuTest, AgreesInDoubleFarBelowFloat) {
  Random random(932);
  for (const Segment& segment : grids(random)) {
    const auto points = test::random_points(random, 60);
    const auto exact = moved({{segment}}, points, precisely(1e-11));
    EXPECT_LT(test::greatest_distance(on_gpu({{segment}}, points, precisely(1e-8)), exact), 1e-7);
  }
}

TEST_F(GridGpuTest, PointsInCellsWithoutNodesKeepTheirBits) {
  Random random(933);
  for (const Segment& segment : grids(random)) {
    auto points = test::random_points(random, 1000, 2.0);
    points.push_back({-0.0, 30, -0.0});
    const auto after = on_gpu({{segment}}, points, default_options(1));
    int outside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (detail::is_used(segment.grid, points[i])) continue;
      ++outside;
      EXPECT_EQ(bits({after[i]}), bits({points[i]}));
    }
    EXPECT_GT(outside, 100);
    EXPECT_GT(test::greatest_distance(after, points), 0.02);
  }
}

// Where v is 0 at first and grows: a point that rests is not left behind.
TEST_F(GridGpuTest, PointsThatRestAtFirstAreMoved) {
  Random random(934);
  Segment segment = test::random_grid(random, true);
  segment.grid.coefficients = SharedVectors(std::vector<Vec3d>(segment.grid.coefficients.size(), Vec3d{0, 0, 0}));
  const auto points = test::random_points(random, 200);
  const auto exact = moved({{segment}}, points, precisely(1e-10));
  EXPECT_LT(test::greatest_distance(on_gpu({{segment}}, points, default_options(2)), exact), 4e-5);
  EXPECT_GT(test::greatest_distance(exact, points), 0.05);
}

// More grids than a call takes, another tool between them, far from the origin, there and back.
TEST_F(GridGpuTest, FlowsOfGridsAndOtherTools) {
  Random random(935);
  const Vec3d far{1000, -2000, 500};
  Flow flow;
  for (int i = 0; i < 20; ++i) {
    Segment grid = test::random_grid(random, i == 7, i % 2 == 0 ? 1 : 0.1);
    grid.end = 0.3;
    grid.grid.origin += far;
    flow.segments.push_back(grid);
    const Vec3d center = far + random.in_box(0.4);
    if (i == 2) flow.segments.push_back(test::translating(Ball<double>{}, center, random.in_box(0.2), {0.1, 0.4}));
  }
  std::vector<Vec3d> points;
  for (const Vec3d& p : test::random_points(random, 300)) points.push_back(far + p);
  const auto exact = moved(flow, points, precisely(1e-10));
  const auto there = on_gpu(flow, points, default_options(2));
  EXPECT_LT(test::greatest_distance(there, exact), 1e-4);
  EXPECT_GT(test::greatest_distance(exact, points), 0.1);
  EXPECT_LT(test::greatest_distance(on_gpu(inverse(flow), there, default_options(2)), points), 2e-4);
}

TEST_F(GridGpuTest, SeveralBuffersThatNobodyWaitsForAreTheSame) {
  Random random(936);
  gpu::GpuOptions options;
  options.most_points = 128;
  gpu::Gpu other(options);
  const Flow flow{{test::random_grid(random, true)}};
  const auto points = test::random_points(random, 300);
  auto uploaded = other.upload(points);
  other.enqueue(flow, uploaded, default_options(1));
  EXPECT_EQ(other.collect(uploaded).status, AdvectStatus::done);
  const auto found = gpu::downloaded(other, uploaded);
  EXPECT_LT(test::greatest_distance(found, on_gpu(flow, points, default_options(1))), 2e-6);
  EXPECT_GT(test::greatest_distance(found, points), 0.1);
}

}  // namespace
}  // namespace knead::grid_gpu_test
