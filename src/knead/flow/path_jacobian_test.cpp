#include "knead/flow/path_jacobian.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random_segments.h"

namespace knead {
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
    loose = std::max(loose, std::abs(volume_drift(strong(), with(1e-2, Integrator::bogacki_shampine), x)));
    x = point;
    tight = std::max(tight, std::abs(volume_drift(strong(), with(1e-11), x)));
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
          const double drift = volume_drift(flow, with(1e-9), x);
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
  EXPECT_EQ(volume_drift(pull, with(1e-5), x), 0);
  EXPECT_EQ(x, (Vec3d{5, 5, 5}));
  x = {-0.6, 0.02, 0.01};  // in the rigid core
  EXPECT_EQ(volume_drift(pull, with(1e-5), x), 0);
  EXPECT_NEAR(x.x, 0.6, 1e-15);
}

}  // namespace
}  // namespace knead
