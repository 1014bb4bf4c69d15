// Volume drifts, Jacobians and velocities.
#include "flow/path_jacobian.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "knead/error.h"
#include "support/random_segments.h"

namespace knead::path_jacobian_test {
namespace {

AdvectOptions with(double tolerance, Integrator integrator = Integrator::tsitouras) {
  AdvectOptions options;
  options.tolerance = tolerance;
  options.integrator = integrator;
  options.precision = Precision::float64;
  options.threads = 1;
  return options;
}

// A long pull past a point beside the tool, and a bend.
Flow strong() {
  Segment pull = test::translating(Ball<double>{}, {-0.6, 0, 0}, {1.2, 0.1, 0}, {0.1, 0.5});
  Segment bend =
      test::resting(Rotation<double>{{0, 1, 0}, 1.2, 1}, HalfSpace<double>{{1, 0, 0}}, {0, 0, 0}, {-0.5, 0.5});
  return {{pull, bend}};
}

const std::vector<Vec3d> kPoints{{0.05, 0.2, 0.1}, {-0.3, 0.25, 0.05}, {0.4, -0.2, 0.2}, {0, 0.1, 0.3}};

// The exact flow keeps volume, so that all of the drift is the integration's, and falls with the tolerance.
TEST(VolumeDrift, FallsWithTheTolerance) {
  double loose = 0;
  double tight = 0;
  for (const Vec3d& point : kPoints) {
    Vec3d x = point;
    loose = std::max(loose, std::abs(volume_drifts(strong(), {&x, 1}, with(1e-2, Integrator::rk4)).front()));
    x = point;
    tight = std::max(tight, std::abs(volume_drifts(strong(), {&x, 1}, with(1e-11)).front()));
  }
  EXPECT_GT(loose, 1e-6);
  EXPECT_LT(tight, 1e-8);
}

// Also for every kind of segment, forwards and backwards; and the path line is that of advect.
TEST(VolumeDrift, IsSmallForEveryKindOfSegment) {
  constexpr unsigned kSeed = 31;
  test::Random random(kSeed);
  for (int round = 0; round < 3; ++round) {
    for (const auto& [name, segment] : test::random_segments(random)) {
      for (const Flow& flow : {Flow{{segment}}, inverse(Flow{{segment}})}) {
        for (int i = 0; i < 4; ++i) {
          const Vec3d point = random.in_box(0.6);
          std::vector<Vec3d> moved{point};
          ASSERT_EQ(advect(flow, moved, with(1e-9)).status, AdvectStatus::done);
          Vec3d x = point;
          const double drift = volume_drifts(flow, {&x, 1}, with(1e-9)).front();
          EXPECT_LT(norm(x - moved[0]), 1e-7) << name << ", seed " << kSeed;
          if (std::isnan(drift)) continue;
          EXPECT_LT(std::abs(drift), 1e-5) << name << ", seed " << kSeed;
        }
      }
    }
  }
}

TEST(VolumeDrift, OfClosedFormsAndUntouchedPointsIsZero) {
  const Flow pull{{strong().segments[0]}};
  Vec3d x{5, 5, 5};
  EXPECT_EQ(volume_drifts(pull, {&x, 1}, with(1e-5)).front(), 0);
  EXPECT_EQ(x, (Vec3d{5, 5, 5}));
  x = {-0.6, 0.02, 0.01};  // in the rigid core
  EXPECT_EQ(volume_drifts(pull, {&x, 1}, with(1e-5)).front(), 0);
  EXPECT_NEAR(x.x, 0.6, 1e-15);
}

std::vector<Vec3d> moved(const Flow& flow, std::vector<Vec3d> points) {
  EXPECT_EQ(advect(flow, points, with(1e-12)).status, AdvectStatus::done);
  return points;
}

// For all kinds of segments: against differences of path lines, det J = 1, and J of the inverse is the inverse of J.
TEST(Jacobians, AreTheDerivativesOfTheFlow) {
  test::Random random(5);
  for (const auto& [name, segment] : test::random_segments(random)) {
    if (std::ranges::any_of(segment.fields, [](const Field& f) {
          return std::holds_alternative<CustomMotion>(f.motion) || std::holds_alternative<CustomRegion>(f.region);
        })) {
      continue;
    }
    const Flow flow{{segment}};
    const std::vector<Mat3d> found = jacobians(flow, kPoints, with(1e-12));
    constexpr double h = 1e-5;
    for (std::size_t i = 0; i < kPoints.size(); ++i) {
      EXPECT_NEAR(determinant(found[i]), 1, 1e-7) << name;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3d e{};
        e[axis] = h;
        const std::vector<Vec3d> ends = moved(flow, {kPoints[i] + e, kPoints[i] - e});
        const Vec3d difference = (ends[0] - ends[1]) / (2 * h);
        EXPECT_LT(norm(difference - found[i] * e / h), 1e-3 * (1 + norm(difference))) << name << " point " << i;
      }
    }
  }
}

// To the bit: whatever is integrated beside it, in whatever order, and by whatever instruction set.
TEST(Jacobians, OfAPointDependOnItAlone) {
  test::Random random(7);
  std::vector<Vec3d> points = kPoints;
  for (int i = 0; i < 60; ++i) points.push_back(random.in_box(0.6));
  const std::vector<Vec3d> reversed(points.rbegin(), points.rend());
  for (const auto& [name, segment] : test::random_segments(random)) {
    if (std::ranges::any_of(segment.fields, [](const Field& f) {
          return std::holds_alternative<CustomMotion>(f.motion) || std::holds_alternative<CustomRegion>(f.region);
        })) {
      continue;
    }
    for (const Flow& flow : {Flow{{segment, segment}}, inverse(Flow{{segment}})}) {
      for (const Integrator integrator : {Integrator::tsitouras, Integrator::rk4}) {
        const std::vector<Mat3d> all = jacobians(flow, points, with(1e-7, integrator));
        std::vector<Mat3d> backwards = jacobians(flow, reversed, with(1e-7, integrator));
        std::ranges::reverse(backwards);
        EXPECT_EQ(all, backwards) << name;
        for (std::size_t i = 0; i < points.size(); i += 7) {
          EXPECT_EQ(all[i], jacobians(flow, {&points[i], 1}, with(1e-7, integrator)).front()) << name;
        }
        setenv("KNEAD_SIMD", "scalar", 1);
        EXPECT_EQ(all, jacobians(flow, points, with(1e-7, integrator))) << name;
        unsetenv("KNEAD_SIMD");
      }
    }
  }
}

TEST(Velocities, AreTheDerivativesOfPathLines) {
  test::Random random(6);
  Flow flow = strong();
  flow.segments.push_back(test::pinning(random, 5, 0.8, 0.3));
  constexpr double h = 1e-4;
  for (const double time : {0.25, 1.0, 1.5, 2.75}) {
    for (const Flow& each : {flow, inverse(flow)}) {
      const std::vector<Vec3d> now = moved(flow_between(each, 0, time), kPoints);
      const std::vector<Vec3d> later = moved(flow_between(each, time, time + h), now);
      const std::vector<Vec3d> found = velocities(each, now, time);
      for (std::size_t i = 0; i < now.size(); ++i) {
        EXPECT_LT(norm((later[i] - now[i]) / h - found[i]), 1e-2 * (1 + norm(found[i]))) << time;
      }
    }
  }
  EXPECT_THROW(velocities(flow, kPoints, 3.5), InvalidInput);
  EXPECT_EQ(velocities({}, kPoints, 0), std::vector<Vec3d>(kPoints.size()));
}

// Parts of parts: every moment is counted from the beginning of the flow that is cut.
TEST(FlowBetween, CutsFlowsThatAreCutAlready) {
  const Flow part = flow_between(strong(), 0.25, 1.75);
  const std::vector<Vec3d> whole = moved(part, kPoints);
  const std::vector<Vec3d> first = moved(flow_between(part, 0, 0.5), kPoints);
  const std::vector<Vec3d> both = moved(flow_between(part, 0.5, 2), first);
  const std::vector<Vec3d> back = moved(flow_between(part, 2, 0), both);
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    EXPECT_LT(norm(both[i] - whole[i]), 1e-9);
    EXPECT_LT(norm(back[i] - kPoints[i]), 1e-9);
  }
  EXPECT_TRUE(flow_between(part, 1, 1).segments.empty());
  EXPECT_THROW(flow_between(part, 0, 2.5), InvalidInput);
  EXPECT_THROW(flow_between(part, -1, 1), InvalidInput);
}

// Cancelled, or where a path line runs away, all points stay as they were.
TEST(Advect, LeavesAllPointsUnlessItIsDone) {
  Progress progress;
  progress.cancel = true;
  AdvectOptions options = with(1e-6);
  options.progress = &progress;
  std::vector<Vec3d> points = kPoints;
  EXPECT_EQ(advect(strong(), points, options).status, AdvectStatus::cancelled);
  EXPECT_EQ(points, kPoints);
  points.push_back({0, 0, 1e5});
  const std::vector<Vec3d> before = points;
  EXPECT_EQ(advect(strong(), points, with(1e-9)).status, AdvectStatus::step_limit);
  EXPECT_EQ(points, before);
}

}  // namespace
}  // namespace knead::path_jacobian_test
