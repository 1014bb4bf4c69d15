// Derivatives with respect to the coefficients of lattices and grids.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "knead/flow.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "support/outcome.h"

namespace knead::coefficients_test {

namespace {

Vec3d random_vector(std::mt19937& random, double size) {
  Vec3d v;
  for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = (static_cast<double>(random()) / 4294967296.0 * 2 - 1) * size;
  return v;
}

// A pull, a grid whose coefficients change in time, a lattice, and a grid under a mask, some coefficients of which are
// 0.
Flow flow_with_coefficients(std::mt19937& random) {
  const auto vector = [&](double size) { return random_vector(random, size); };
  Session session;
  ImplicitStroke pull;
  pull.path = {{0, 0, 0}, {0.1, 0.2, 0}};
  pull.inner = 0.2;
  pull.outer = 0.7;
  GridStroke first;
  first.grid.origin = {-0.5, -0.6, -0.4};
  first.grid.spacing = 0.31;
  first.grid.counts = {4, 3, 4};
  std::vector<Vec3d> begin(48);
  std::vector<Vec3d> end(48);
  for (Vec3d& v : begin) v = vector(0.05);
  for (Vec3d& v : end) v = vector(0.05);
  first.grid.coefficients = SharedVectors(begin);
  first.grid.end_coefficients = SharedVectors(end);
  LatticeStroke lattice;
  lattice.mode = LatticeMode::spline;
  lattice.origin = {-2, -2, -2};
  lattice.lengths = {4, 4, 4};
  lattice.counts = {3, 2, 4};
  lattice.displacements.resize(24);
  for (Vec3d& d : lattice.displacements) d = vector(0.3);
  MaskStroke mask;
  mask.points = {{0.2, 0.3, 0.1}};
  mask.width = 0.3;
  GridStroke second;
  second.grid.origin = {0, 0, 0};
  second.grid.spacing = 0.2;
  second.grid.counts = {2, 1, 3};
  second.grid.coefficients = SharedVectors({vector(0.03), {}, vector(0.03), {}, {}, {}});
  session.strokes = {{pull}, {first}, {lattice}, {mask}, {second}};
  return flow_of(session);
}

Flow with_coefficients(Flow flow, const FlowCoefficients& coefficients) {
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    Segment& segment = flow.segments[i];
    const std::vector<Vec3d>& own = coefficients[i];
    if (!segment.lattice.is_empty()) segment.lattice.displacements = SharedVectors(own);
    if (segment.grid.is_empty()) continue;
    const auto middle = own.begin() + static_cast<std::ptrdiff_t>(segment.grid.coefficients.size());
    segment.grid.coefficients = SharedVectors({own.begin(), middle});
    if (middle != own.end()) segment.grid.end_coefficients = SharedVectors({middle, own.end()});
  }
  return flow;
}

std::vector<Vec3d> points() {
  std::mt19937 random(47);
  std::vector<Vec3d> result(40);
  for (Vec3d& p : result) p = random_vector(random, 0.6);
  return result;
}

std::vector<Vec3d> random_vectors(std::mt19937& random, std::size_t count) {
  std::vector<Vec3d> result(count);
  for (Vec3d& v : result) v = random_vector(random, 1);
  return result;
}

}  // namespace

TEST(Coefficients, DerivativesAreThoseOfDifferences) {
  std::mt19937 random(48);
  const Flow flow = flow_with_coefficients(random);
  const FlowCoefficients here = coefficients_of(flow);
  FlowCoefficients direction;
  for (const std::vector<Vec3d>& own : here) direction.push_back(random_vectors(random, own.size()));
  const auto moved_by = [&](double h) {
    FlowCoefficients there = here;
    for (std::size_t i = 0; i < there.size(); ++i) {
      for (std::size_t n = 0; n < there[i].size(); ++n) there[i][n] += direction[i][n] * h;
    }
    std::vector<Vec3d> result = points();
    AdvectOptions options;
    options.tolerance = 1e-13;
    options.precision = Precision::float64;
    EXPECT_EQ(advect(with_coefficients(flow, there), result, options).status, AdvectStatus::done);
    return result;
  };
  const PointTangents found = coefficient_jvp(flow, points(), direction, {.relative_tolerance = 1e-11});
  constexpr double kStep = 1e-4;
  const std::vector<Vec3d> after = moved_by(kStep);
  const std::vector<Vec3d> before = moved_by(-kStep);
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Vec3d difference = (after[i] - before[i]) / (2 * kStep);
    EXPECT_LE(norm(found.tangents[i] - difference), 2e-6 * std::max(1.0, norm(difference))) << i;
  }
}

TEST(Coefficients, DerivativesBackwardsAreThoseForwards) {
  std::mt19937 random(49);
  const Flow flow = flow_with_coefficients(random);
  const std::vector<Vec3d> gradient = random_vectors(random, points().size());
  const DerivativeOptions options{.relative_tolerance = 1e-10};
  const CoefficientGradient back = coefficient_vjp(flow, points(), gradient, options);
  ASSERT_EQ(back.coefficients.size(), flow.segments.size());
  int zeros = 0;
  for (std::size_t i = 0; i < flow.segments.size(); ++i) {
    const std::size_t count = coefficients_of(flow)[i].size();
    ASSERT_EQ(back.coefficients[i].size(), count);
    for (std::size_t n = 0; n < count; n += 1 + count / 12) {
      FlowCoefficients direction = coefficients_of(flow);
      for (std::vector<Vec3d>& own : direction) std::fill(own.begin(), own.end(), Vec3d{0, 0, 0});
      direction[i][n] = {0.5, -0.3, 0.8};
      zeros += coefficients_of(flow)[i][n] == Vec3d{0, 0, 0} ? 1 : 0;
      const PointTangents forwards = coefficient_jvp(flow, points(), direction, options);
      double sum = 0;
      double size = 1e-3;
      for (std::size_t k = 0; k < gradient.size(); ++k) {
        sum += dot(gradient[k], forwards.tangents[k]);
        size += std::abs(dot(gradient[k], forwards.tangents[k]));
      }
      EXPECT_NEAR(dot(back.coefficients[i][n], direction[i][n]), sum, 1e-8 * size) << i << ' ' << n;
    }
  }
  EXPECT_GT(zeros, 2);
}

TEST(Coefficients, GradientsHaveTheSameBitsForEveryThreadAndInstruction) {
  std::mt19937 random(50);
  const Flow flow = flow_with_coefficients(random);
  std::vector<Vec3d> many;
  for (int i = 0; i < 3000; ++i) many.push_back(random_vector(random, 0.7));
  const std::vector<Vec3d> gradient = random_vectors(random, many.size());
  DerivativeOptions options{.relative_tolerance = 1e-6, .threads = 1};
  const CoefficientGradient one = coefficient_vjp(flow, many, gradient, options);
  options.threads = 3;
  for (const std::string& name : test::simd_names()) {
    const test::Simd chosen(name);
    const CoefficientGradient other = coefficient_vjp(flow, many, gradient, options);
    EXPECT_EQ(other.coefficients, one.coefficients) << name;
    EXPECT_EQ(other.points, one.points) << name;
  }
}

// Paths of about two spacings through a grid of noise.
TEST(Coefficients, GradientsOfGridsAreAsAccurateAsAsked) {
  std::mt19937 random(51);
  Flow flow;
  PotentialGrid& grid = flow.segments.emplace_back().grid;
  grid.origin = {-1, -1, -1};
  grid.spacing = 0.2;
  grid.counts = {11, 11, 11};
  std::vector<Vec3d> noise(11 * 11 * 11);
  for (Vec3d& v : noise) v = random_vector(random, 0.15);
  grid.coefficients = SharedVectors(noise);
  std::vector<Vec3d> many;
  for (int i = 0; i < 400; ++i) many.push_back(random_vector(random, 0.8));
  const std::vector<Vec3d> gradient = random_vectors(random, many.size());
  const auto gradient_at = [&](double tolerance) {
    return coefficient_vjp(flow, many, gradient, {.relative_tolerance = tolerance, .diagonal = 2.0});
  };
  std::vector<Vec3d> moved = many;
  ASSERT_EQ(advect(flow, moved, {.tolerance = 1e-9, .precision = Precision::float64}).status, AdvectStatus::done);
  double path = 0;
  for (std::size_t i = 0; i < many.size(); ++i) path += norm(moved[i] - many[i]) / static_cast<double>(many.size());
  EXPECT_GT(path, 1.5 * grid.spacing);
  const CoefficientGradient exact = gradient_at(1e-12);
  for (const double tolerance : {1e-9, 1e-7, 1e-5, 1e-4}) {
    const CoefficientGradient found = gradient_at(tolerance);
    double error = 0;
    double size = 0;
    for (std::size_t n = 0; n < noise.size(); ++n) {
      error += norm2(found.coefficients[0][n] - exact.coefficients[0][n]);
      size += norm2(exact.coefficients[0][n]);
    }
    EXPECT_LE(std::sqrt(error), 10 * tolerance * std::sqrt(size)) << tolerance;
  }
}

// A grid of zeros moves nothing, and its derivatives are those of v: curl of one spline.
TEST(Coefficients, AGridAtRestHasDerivatives) {
  GridStroke stroke;
  stroke.grid.origin = {0, 0, 0};
  stroke.grid.spacing = 0.5;
  stroke.grid.counts = {1, 1, 1};
  stroke.grid.coefficients = SharedVectors({{0, 0, 0}});
  Flow flow;
  flow.segments.emplace_back().grid = stroke.grid;
  const std::vector<Vec3d> point{{0.2, 0.1, -0.3}};
  const CoefficientGradient back = coefficient_vjp(flow, point, std::vector<Vec3d>{{1, 2, 3}}, {});
  flow.segments[0].grid.coefficients = SharedVectors({{1, 0, 0}});
  const Vec3d by_x = velocities(flow, point, 0)[0];
  EXPECT_NEAR(back.coefficients[0][0].x, dot(by_x, Vec3d{1, 2, 3}), 1e-13);
  EXPECT_GT(std::abs(back.coefficients[0][0].x), 0.01);
  EXPECT_EQ(back.points[0], (Vec3d{1, 2, 3}));
}

}  // namespace knead::coefficients_test
