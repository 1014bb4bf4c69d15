// Segments whose field is a grid of potentials.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "field/dual.h"
#include "field/grid.h"
#include "flow/culling.h"
#include "flow/masked.h"
#include "flow/path_jacobian.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "support/outcome.h"
#include "support/random_grids.h"
#include "support/random_segments.h"

namespace knead::grid_test {
namespace {

using test::moved;
using test::outcome_of;
using test::precisely;
using test::Random;
using test::random_grid;

constexpr double kDiagonal = 2;

// The cubic B-spline and its derivative.
double spline(double x) {
  const double a = std::abs(x);
  if (a >= 2) return 0;
  return a < 1 ? (4 - 6 * a * a + 3 * a * a * a) / 6 : std::pow(2 - a, 3) / 6;
}

double slope(double x) {
  const double a = std::abs(x);
  const double sign = x < 0 ? -1 : 1;
  if (a >= 2) return 0;
  return sign * (a < 1 ? (9 * a * a - 12 * a) / 6 : -0.5 * (2 - a) * (2 - a));
}

// v = curl A by its definition, from all nodes.
Vec3d reference(const PotentialGrid& grid, const Vec3d& x, double t) {
  Vec3d v{0, 0, 0};
  std::size_t node = 0;
  for (int k = 0; k < grid.counts[2]; ++k) {
    for (int j = 0; j < grid.counts[1]; ++j) {
      for (int i = 0; i < grid.counts[0]; ++i, ++node) {
        const Vec3d d = (x - grid.origin) / grid.spacing - Vec3d{1.0 * i, 1.0 * j, 1.0 * k};
        const Vec3d gradient = Vec3d{slope(d.x) * spline(d.y) * spline(d.z), spline(d.x) * slope(d.y) * spline(d.z),
                                     spline(d.x) * spline(d.y) * slope(d.z)} /
                               grid.spacing;
        Vec3d a = grid.coefficients[node];
        if (!grid.end_coefficients.empty()) a = a * (1 - t) + grid.end_coefficients[node] * t;
        v += cross(gradient, a);
        if (!grid.growth.empty()) v += gradient * grid.growth[node];
      }
    }
  }
  return v;
}

std::vector<Segment> kinds(Random& random) {
  return {random_grid(random), random_grid(random, false, 0.1), random_grid(random, true),
          random_grid(random, true, 0.1)};
}

SharedNumbers growth_of(const PotentialGrid& grid, Random& random) {
  std::vector<double> growth;
  for (std::size_t i = 0; i < grid.coefficients.size(); ++i) growth.push_back(random.uniform(-0.02, 0.02));
  return SharedNumbers(std::move(growth));
}

Flow part_of(Segment segment, double begin, double end) {
  segment.begin = begin;
  segment.end = end;
  return {{segment}};
}

// Path lines by the classical method in many steps.
Vec3d followed(const Segment& segment, Vec3d x, int steps) {
  const double h = (segment.end - segment.begin) / steps;
  const auto v = [&](const Vec3d& at, double t) { return reference(segment.grid, at, t); };
  for (int i = 0; i < steps; ++i) {
    const double t = segment.begin + i * h;
    const Vec3d k0 = v(x, t);
    const Vec3d k1 = v(x + k0 * (0.5 * h), t + 0.5 * h);
    const Vec3d k2 = v(x + k1 * (0.5 * h), t + 0.5 * h);
    const Vec3d k3 = v(x + k2 * h, t + h);
    x += (k0 + (k1 + k2) * 2.0 + k3) * (h / 6);
  }
  return x;
}

AdvectOptions options_of(Precision precision, double tolerance) {
  AdvectOptions options = precisely(tolerance);
  options.precision = precision;
  return options;
}

TEST(Grid, VelocityIsTheCurlOfThePotential) {
  Random random(901);
  for (const Segment& segment : kinds(random)) {
    const auto points = test::random_points(random, 400);
    for (const double t : {0.0, 0.3, 1.0}) {
      const auto v = velocities({{segment}}, points, t);
      double most = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        most = std::max(most, norm(v[i]));
        EXPECT_LE(norm(v[i] - reference(segment.grid, points[i], t)), 1e-13);
      }
      EXPECT_GT(most, 0.05);
    }
  }
}

TEST(Grid, PotentialsCurlByDifferencesIsTheVelocity) {
  Random random(902);
  const Segment segment = random_grid(random, true);
  const detail::GridNodes<double> nodes(segment.grid);
  const double h = 1e-5;
  for (int n = 0; n < 100; ++n) {
    const Vec3d y = random.in_box(0.8);
    std::array<Vec3d, 3> by;  // dA along each axis
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3d d{0, 0, 0};
      d[axis] = h;
      by[axis] =
          (evaluate_grid(nodes.view, y + d, 0.4).potential - evaluate_grid(nodes.view, y - d, 0.4).potential) / (2 * h);
    }
    const Vec3d curl{by[1].z - by[2].y, by[2].x - by[0].z, by[0].y - by[1].x};
    EXPECT_LE(norm(curl - evaluate_grid(nodes.view, y, 0.4).velocity), 1e-8);
  }
}

TEST(Grid, DivergenceIsZeroByExactDerivatives) {
  Random random(903);
  for (const Segment& segment : kinds(random)) {
    const detail::GridNodes<double> nodes(segment.grid);
    double greatest = 0;
    for (int n = 0; n < 1000; ++n) {
      const auto value = evaluate_grid(nodes.view, variables(random.in_box(0.8)), Dual(0.7));
      const Vec3<Dual>& v = value.velocity;
      greatest = std::max(greatest, std::abs(v.x.g.x));
      EXPECT_LE(std::abs(v.x.g.x + v.y.g.y + v.z.g.z), 1e-14);
    }
    EXPECT_GT(greatest, 0.1);
  }
}

// Divergence and gradient of v = curl A + grad p by dual numbers, and the mover's own: det J is exactly exp of the
// integral of div v along a path line.
TEST(Grid, GrowthAddsTheGradientOfItsPotential) {
  Random random(914);
  for (Segment segment : kinds(random)) {
    segment.grid.growth = growth_of(segment.grid, random);
    const detail::GridNodes<double> nodes(segment.grid);
    const double h = 1e-5;
    for (int n = 0; n < 200; ++n) {
      const Vec3d y = random.in_box(0.8);
      const Vec3d x = y + nodes.cells.center();
      EXPECT_LE(norm(evaluate_grid(nodes.view, y, 0.3).velocity - reference(segment.grid, x, 0.3)), 1e-13);
      const auto place = detail::place_in(nodes.view, y);
      const auto slope = detail::slope_in_cell(nodes.view, detail::node_at(nodes.view, place), place.within, 0.3);
      const Vec3<Dual> v = evaluate_grid(nodes.view, variables(y), Dual(0.3)).velocity;
      EXPECT_LE(norm(slope.velocity - values(v)), 1e-13);
      for (std::size_t row = 0; row < 3; ++row) EXPECT_LE(norm(slope.rows[row] - v[row].g), 1e-12);
      for (std::size_t axis = 0; axis < 3; ++axis) {  // C1: the gradient is continuous
        Vec3d d{0, 0, 0};
        d[axis] = h;
        const Vec3d by =
            (evaluate_grid(nodes.view, y + d, 0.3).velocity - evaluate_grid(nodes.view, y - d, 0.3).velocity) / (2 * h);
        for (std::size_t row = 0; row < 3; ++row) EXPECT_NEAR(by[row], slope.rows[row][axis], 1e-3);
      }
    }
  }
}

TEST(Grid, GrowthMovesAndComesBackAndIsTheSameEverywhere) {
  Random random(915);
  for (Segment segment : kinds(random)) {
    segment.grid.growth = growth_of(segment.grid, random);
    ASSERT_TRUE(changes_volume(segment));
    const Flow flow{{segment}};
    const auto points = test::random_points(random, 300);
    const auto options = options_of(Precision::float64, 1e-10);
    const auto after = moved(flow, points, options);
    for (std::size_t i = 0; i < 40; ++i) EXPECT_LE(norm(after[i] - followed(segment, points[i], 400)), 1e-8);
    const auto back = moved(inverse(flow), after, options);
    EXPECT_LE(test::greatest_distance(back, points), 1e-8);
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      auto some = options_of(precision, 1e-5);
      const auto first = outcome_of(flow, points, some);
      some.threads = 2;
      for (const std::string& name : test::simd_names()) {
        const test::Simd simd(name);
        EXPECT_EQ(outcome_of(flow, points, some), first) << name;
      }
    }
  }
}

// d/dt log det J = div v along the path line, whatever way.
TEST(Grid, DetOfAGrowthIsTheIntegralOfItsDivergence) {
  Random random(916);
  for (Segment segment : kinds(random)) {
    segment.grid.growth = growth_of(segment.grid, random);
    const auto points = test::random_points(random, 20);
    const auto gradients = jacobians({{segment}}, points, options_of(Precision::float64, 1e-10));
    const detail::GridNodes<double> nodes(segment.grid);
    double farthest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      double sum = 0;
      constexpr int kSteps = 200;
      Segment part = segment;
      Vec3d at = points[i];
      for (int step = 0; step < kSteps; ++step) {
        const double t = (step + 0.5) / kSteps;
        part.begin = step == 0 ? 0 : part.end;
        part.end = t;
        at = followed(part, at, 1);
        const auto v = evaluate_grid(nodes.view, variables(at - nodes.cells.center()), Dual(t)).velocity;
        sum += (v.x.g.x + v.y.g.y + v.z.g.z) / kSteps;
      }
      const double det = determinant(gradients[i]);
      farthest = std::max(farthest, std::abs(det - 1));
      EXPECT_NEAR(det, std::exp(sum), 1e-4);
    }
    EXPECT_GT(farthest, 0.05);
  }
}

TEST(Grid, IsExactlyZeroTwoSpacingsBeyondTheNodesInUse) {
  Segment segment;
  segment.grid = {{0, 0, 0}, 0.25, {9, 9, 9}, {}, {}};
  std::vector<Vec3d> coefficients(729, Vec3d{0, 0, 0});
  coefficients[4 + 9 * (4 + 9 * 4)] = {0.1, -0.2, 0.3};  // at (1, 1, 1)
  segment.grid.coefficients = SharedVectors(coefficients);
  const Box box = detail::box_in_use(segment.grid);
  EXPECT_EQ(box.min, (Vec3d{1, 1, 1}));
  EXPECT_EQ(box.max, (Vec3d{1, 1, 1}));
  EXPECT_TRUE(detail::box_in_use({{0, 0, 0}, 1, {1, 1, 1}, SharedVectors({{0, 0, 0}}), {}}).empty());
  Random random(904);
  std::vector<Vec3d> inside;
  std::vector<Vec3d> outside;
  for (int n = 0; n < 4000; ++n) {
    const Vec3d d = random.in_box(0.8);
    const double far = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    if (far > 0.5) outside.push_back(Vec3d{1, 1, 1} + d);
    if (far < 0.45) inside.push_back(Vec3d{1, 1, 1} + d);
  }
  outside.push_back({1e9, -1e12, 1e300});
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    const auto options = options_of(precision, 1e-6);
    EXPECT_EQ(test::bits(moved({{segment}}, outside, options)), test::bits(outside));
    const auto after = moved({{segment}}, inside, options);
    for (std::size_t i = 0; i < inside.size(); ++i) EXPECT_NE(after[i], inside[i]);
  }
  const FlowSupport support({{segment}});
  EXPECT_TRUE(support.may_move({1.45, 1, 1}, 0.01));
  EXPECT_FALSE(support.may_move({1.6, 1, 1}, 0.09));
  EXPECT_FALSE(support.may_move({0.3, 1, 1}, 0.1));
}

TEST(Grid, CullingMissesNoUsedCell) {
  Random random(905);
  for (const Segment& segment : kinds(random)) {
    const detail::Culling culling(segment);
    int missed = 0;
    for (int n = 0; n < 4000; ++n) {
      const Vec3d x = random.in_box(1.4);
      const bool misses = culling.misses({x, 0.05});
      missed += misses ? 1 : 0;
      EXPECT_FALSE(misses && detail::is_used(segment.grid, x));
    }
    EXPECT_GT(missed, 100);
  }
}

// Not in float to 1e-6: its steps are never shorter than 1/16 of the longest, and rounding takes its share.
TEST(Grid, PathLinesAreThoseOfManySmallSteps) {
  Random random(906);
  for (const Segment& segment : kinds(random)) {
    const auto points = test::random_points(random, 60);
    for (const auto& [begin, end] : {std::pair{0.0, 1.0}, {1.0, 0.2}}) {
      const Flow flow = part_of(segment, begin, end);
      std::vector<Vec3d> expected;
      for (const Vec3d& p : points) expected.push_back(followed(flow.segments[0], p, 200));
      const auto error = [&](Precision precision, double tolerance) {
        return test::greatest_distance(moved(flow, points, options_of(precision, tolerance)), expected);
      };
      for (const double tolerance : {1e-4, 1e-5}) EXPECT_LE(error(Precision::float32, tolerance), tolerance);
      for (const double tolerance : {1e-4, 1e-5, 1e-6}) EXPECT_LE(error(Precision::float64, tolerance), tolerance);
    }
  }
}

TEST(Grid, ComesBackInDouble) {
  Random random(907);
  for (const Segment& segment : kinds(random)) {
    const auto points = test::random_points(random, 500);
    const auto options = options_of(Precision::float64, 1e-10);
    const auto back = moved(inverse({{segment}}), moved({{segment}}, points, options), options);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LE(norm(back[i] - points[i]), 1e-8 * kDiagonal);
  }
}

TEST(Grid, PartsCompose) {
  Random random(908);
  constexpr int kParts = 50;
  const double tolerance = 1e-5;
  for (const Segment& segment : kinds(random)) {
    const auto points = test::random_points(random, 500);
    Flow parts;
    for (int i = 0; i < kParts; ++i) {
      parts.segments.push_back(part_of(segment, 1.0 * i / kParts, (i + 1.0) / kParts).segments[0]);
    }
    const auto whole = moved({{segment}}, points, options_of(Precision::float64, tolerance));
    const auto in_parts = moved(parts, points, options_of(Precision::float64, tolerance));
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LE(norm(whole[i] - in_parts[i]), 2 * tolerance);
  }
}

TEST(Grid, GivesTheSameBitsEverywhere) {
  Random random(909);
  const Mask mask(std::vector<Vec3d>{{-0.5, 0, 0}, {-0.3, 0.2, 0.1}}, {}, 0.3);
  for (const Segment& plain : kinds(random)) {
    for (const bool masked : {false, true}) {
      Segment segment = plain;
      if (masked) segment.mask = mask;
      const Flow flow{{segment, part_of(segment, 0.7, 0.1).segments[0]}};
      const auto points = test::random_points(random, 1331);
      auto reversed = points;
      std::reverse(reversed.begin(), reversed.end());
      for (const Precision precision : {Precision::float32, Precision::float64}) {
        auto options = options_of(precision, 1e-5);
        const auto first = outcome_of(flow, points, options);
        for (const std::string& name : test::simd_names()) {
          const test::Simd simd(name);
          EXPECT_EQ(outcome_of(flow, points, options), first) << name << (masked ? ", masked" : "");
        }
        options.threads = 2;
        EXPECT_EQ(outcome_of(flow, points, options), first);
        auto after = moved(flow, reversed, options);
        std::reverse(after.begin(), after.end());
        EXPECT_EQ(test::bits(after), first.points);
      }
    }
  }
}

TEST(Grid, MasksHoldPointsAndKeepVolume) {
  Random random(910);
  auto points = test::random_points(random, 600);
  std::vector<Vec3d> held;
  for (const Vec3d& p : points) {
    if (p.x < 0) held.push_back(p);
  }
  Segment segment = random_grid(random);
  segment.mask = Mask(held, {}, 0.3);
  ASSERT_TRUE(detail::mask_on(segment).acts);
  const auto after = moved({{segment}}, points, options_of(Precision::float32, 1e-6));
  int free = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (segment.mask.holds(points[i])) {
      EXPECT_EQ(after[i], points[i]);
    } else {
      free += after[i] == points[i] ? 0 : 1;
    }
  }
  EXPECT_GT(free, 50);
  const auto options = options_of(Precision::float64, 1e-9);
  auto some = std::vector<Vec3d>(points.begin(), points.begin() + 60);
  for (const double drift : volume_drifts({{segment}}, some, options)) EXPECT_LE(std::abs(drift), 1e-6);
}

TEST(Grid, JacobiansAreThoseOfDifferencesAndKeepVolume) {
  Random random(911);
  const double h = 1e-4;
  for (const Segment& segment : kinds(random)) {
    const Flow flow{{segment}};
    const auto points = test::random_points(random, 40);
    const auto options = options_of(Precision::float64, 1e-10);
    const auto gradients = jacobians(flow, points, options);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LE(std::abs(determinant(gradients[i]) - 1), 1e-7);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3d d{0, 0, 0};
        d[axis] = h;
        const auto ends = moved(flow, {points[i] - d, points[i] + d}, options);
        EXPECT_LE(norm((ends[1] - ends[0]) / (2 * h) - gradients[i].column(axis)), 2e-3);
      }
    }
  }
}

// The second derivatives of A jump at no place, the third do; so the gradient is compared where v is evaluated.
TEST(Grid, GradientsAreThoseOfDualNumbers) {
  Random random(912);
  for (const Segment& segment : kinds(random)) {
    const detail::GridNodes<double> nodes(segment.grid);
    for (int n = 0; n < 200; ++n) {
      const Vec3d y = random.in_box(0.8);
      const auto place = detail::place_in(nodes.view, y);
      const auto slope = detail::slope_in_cell(nodes.view, detail::node_at(nodes.view, place), place.within, 0.3);
      const Vec3<Dual> v = evaluate_grid(nodes.view, variables(y), Dual(0.3)).velocity;
      EXPECT_LE(norm(slope.velocity - values(v)), 1e-13);
      for (std::size_t row = 0; row < 3; ++row) EXPECT_LE(norm(slope.rows[row] - v[row].g), 1e-12);
    }
  }
}

TEST(Grid, WhatIsWrongIsNamed) {
  Random random(913);
  const auto error_of = [](const Segment& segment) -> std::string {
    try {
      validate(Flow{{segment}});
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  const Segment good = random_grid(random, true);
  EXPECT_EQ(error_of(good), "");
  Segment bad = good;
  bad.grid.spacing = 0;
  EXPECT_NE(error_of(bad).find("spacing"), std::string::npos);
  bad = good;
  bad.grid.counts = {1 << 30, 1 << 30, 1 << 30};
  EXPECT_NE(error_of(bad).find("16 million"), std::string::npos);
  bad.grid.counts = {-5, -4, 6};
  EXPECT_NE(error_of(bad).find("1 or more nodes"), std::string::npos);
  bad.grid.counts = {5, 4, 5};
  EXPECT_NE(error_of(bad).find("one coefficient for each node"), std::string::npos);
  bad = good;
  bad.grid.end_coefficients = SharedVectors({{1, 2, 3}});
  EXPECT_NE(error_of(bad).find("one coefficient for each node"), std::string::npos);
  bad = good;
  bad.grid.coefficients = SharedVectors(std::vector<Vec3d>(120, {0, std::numeric_limits<double>::quiet_NaN(), 0}));
  EXPECT_NE(error_of(bad).find("not finite"), std::string::npos);
  bad = good;
  bad.grid.growth = SharedNumbers({1});
  EXPECT_NE(error_of(bad).find("one coefficient for each node"), std::string::npos);
  bad.grid.growth = SharedNumbers(std::vector<double>(good.grid.coefficients.size(), kInfinity));
  EXPECT_NE(error_of(bad).find("not finite"), std::string::npos);
  bad = good;
  bad.displacement = {1, 0, 0};
  EXPECT_NE(error_of(bad).find("no displacement"), std::string::npos);
}

}  // namespace
}  // namespace knead::grid_test
