// Segments that are sums: their parts act at the same time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "flow/path_jacobian.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "support/outcome.h"
#include "support/random_grids.h"
#include "support/random_segments.h"

namespace knead::sum_test {
namespace {

using test::NamedSegment;
using test::Outcome;
using test::outcome_of;
using test::Random;

constexpr Precision kPrecisions[] = {Precision::float32, Precision::float64};

Segment sum_of(std::vector<Segment> parts) {
  Segment sum;
  sum.parts = std::move(parts);
  return sum;
}

// Each kind of segment added to the one of the next kind; sums of four; of a grid; some in limit cylinders.
std::vector<NamedSegment> random_sums(Random& random) {
  std::vector<NamedSegment> kinds = test::random_segments(random);
  std::erase_if(kinds, [](const NamedSegment& named) { return named.segment.time_law == TimeLaw::pinned; });
  Segment grid;
  grid.grid = test::random_grid(random, true).grid;
  kinds.push_back({"grid", grid});
  std::vector<NamedSegment> sums;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const NamedSegment& next = kinds[(i + 1) % kinds.size()];
    sums.push_back({kinds[i].name + " and " + next.name, sum_of({kinds[i].segment, next.segment})});
  }
  sums.push_back({"four", sum_of({kinds[0].segment, kinds[2].segment, kinds[8].segment, kinds[5].segment})});
  Segment limit_cylinders = sum_of({kinds[13].segment, kinds[11].segment});
  limit_cylinders.parts[0].limit_cylinder = LimitCylinder{{0.2, 0, 0}, random.unit(), 0.3};
  limit_cylinders.parts[1].limit_cylinder = LimitCylinder{{-0.2, 0, 0}, random.unit(), 0.4};
  sums.push_back({"limit cylinders", limit_cylinders});
  return sums;
}

std::vector<NamedSegment> whole_and_cut(Random& random) {
  std::vector<NamedSegment> result;
  for (const NamedSegment& whole : random_sums(random)) {
    for (const auto& [begin, end] : {std::pair{0.0, 1.0}, {1.0, 0.0}, {0.25, 0.8}, {0.7, 0.1}}) {
      result.push_back(whole);
      result.back().segment.begin = begin;
      result.back().segment.end = end;
      result.back().name += " from " + std::to_string(begin);
    }
  }
  return result;
}

AdvectOptions options_of(Precision precision, double tolerance = 1e-5) {
  AdvectOptions options = test::precisely(tolerance);
  options.precision = precision;
  return options;
}

// A ball that turns about z, and its image in x = 0, which it meets.
Segment turn_and_image(double degrees) {
  const double rate = degrees * std::numbers::pi / 180;
  const Thresholds<double> between{0.2, 0.7};
  const Rotation<double> turn{{0, 0, 1}, rate, 0, RotationGauge::radial};
  const Rotation<double> image{{0, 0, 1}, -rate, 0, RotationGauge::radial};
  return sum_of({test::resting(turn, Ball<double>{}, {0.3, 0.1, 0}, between),
                 test::resting(image, Ball<double>{}, {-0.3, 0.1, 0}, between)});
}

// Steps of the classical method, with the velocities of the parts.
std::vector<Vec3d> by_small_steps(const Segment& sum, std::vector<Vec3d> x) {
  constexpr int kSteps = 400;
  const auto slopes = [&](const std::vector<Vec3d>& places, double t) {
    std::vector<Vec3d> all(places.size());
    for (const Segment& part : sum.parts) {
      const std::vector<Vec3d> own = velocities(Flow{{part}}, places, t);
      for (std::size_t i = 0; i < all.size(); ++i) all[i] += own[i];
    }
    return all;
  };
  const auto along = [&](const std::vector<Vec3d>& k, double h) {
    std::vector<Vec3d> places = x;
    for (std::size_t i = 0; i < x.size(); ++i) places[i] += k[i] * h;
    return places;
  };
  const double h = 1.0 / kSteps;
  for (int step = 0; step < kSteps; ++step) {
    const double t = step * h;
    const double after = std::min(t + h, 1.0);
    const std::vector<Vec3d> k1 = slopes(x, t);
    const std::vector<Vec3d> k2 = slopes(along(k1, h / 2), t + h / 2);
    const std::vector<Vec3d> k3 = slopes(along(k2, h / 2), t + h / 2);
    const std::vector<Vec3d> k4 = slopes(along(k3, h), after);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += (k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i]) * (h / 6);
  }
  return x;
}

TEST(Sum, VelocitiesAreThoseOfThePartsTogether) {
  Random random(91);
  for (const NamedSegment& named : random_sums(random)) {
    const auto points = test::random_points(random, 200);
    for (const double t : {0.0, 0.3, 1.0}) {
      const std::vector<Vec3d> all = velocities(Flow{{named.segment}}, points, t);
      std::vector<Vec3d> sum(points.size());
      for (const Segment& part : named.segment.parts) {
        const std::vector<Vec3d> own = velocities(Flow{{part}}, points, t);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += own[i];
      }
      EXPECT_LT(test::greatest_distance(all, sum), 1e-14) << named.name;
    }
  }
}

TEST(Sum, PathLinesFollowTheSumOfTheVelocities) {
  Random random(92);
  for (const NamedSegment& named : random_sums(random)) {
    if (named.name == "limit cylinders") continue;
    const auto points = test::random_points(random, 40);
    const std::vector<Vec3d> expected = by_small_steps(named.segment, points);
    const Flow flow{{named.segment}};
    EXPECT_GT(test::greatest_distance(expected, points), 1e-2) << named.name;
    EXPECT_LT(test::greatest_distance(test::moved(flow, points, options_of(Precision::float64, 1e-9)), expected), 3e-6)
        << named.name;
    EXPECT_LT(test::greatest_distance(test::moved(flow, points, options_of(Precision::float32, 1e-5)), expected), 2e-5)
        << named.name;
  }
}

TEST(Sum, IsNotItsPartsOneAfterTheOther) {
  const Segment one = test::translating(Ball<double>{}, {0.2, 0, 0}, {0.5, 0, 0}, {0.2, 0.8});
  const Segment other = test::translating(Ball<double>{}, {-0.2, 0, 0}, {-0.5, 0, 0}, {0.2, 0.8});
  const std::vector<Vec3d> middle{{0, 0, 0}, {0, 0.3, 0.1}};
  const AdvectOptions options = options_of(Precision::float64);
  EXPECT_GT(test::greatest_distance(test::moved(Flow{{one, other}}, middle, options),
                                    test::moved(Flow{{sum_of({one, other})}}, middle, options)),
            0.05);
}

TEST(Sum, EveryInstructionSetThreadAndOrderGivesTheSameBits) {
  Random random(93);
  for (const NamedSegment& named : whole_and_cut(random)) {
    const Flow flow{{named.segment}};
    const auto points = test::random_points(random, 331);
    std::vector<Vec3d> backwards(points.rbegin(), points.rend());
    for (const Precision precision : kPrecisions) {
      AdvectOptions options = options_of(precision);
      options.threads = 1;
      const Outcome first = outcome_of(flow, points, options);
      for (const std::string& name : test::simd_names()) {
        const test::Simd simd(name);
        EXPECT_EQ(outcome_of(flow, points, options), first) << named.name << ", " << name;
      }
      options.threads = 7;
      Outcome reversed = outcome_of(flow, backwards, options);
      std::reverse(reversed.steps.begin(), reversed.steps.end());
      for (std::size_t i = 0; i < points.size() / 2; ++i) {
        std::swap_ranges(reversed.points.begin() + static_cast<std::ptrdiff_t>(3 * i),
                         reversed.points.begin() + static_cast<std::ptrdiff_t>(3 * i + 3),
                         reversed.points.end() - static_cast<std::ptrdiff_t>(3 * i + 3));
      }
      EXPECT_EQ(reversed, first) << named.name;
    }
  }
}

// Movers are made for the parts that points need, by whichever thread is the first.
TEST(Sum, ThreadsDoNotMatterWhereManyPointsNeedDifferentParts) {
  Random random(102);
  const Segment sum = turn_and_image(60);
  const auto points = test::random_points(random, 20000, 1.2);
  AdvectOptions options = options_of(Precision::float32);
  options.threads = 1;
  const Outcome one = outcome_of(Flow{{sum, sum}}, points, options);
  options.threads = 8;
  EXPECT_EQ(outcome_of(Flow{{sum, sum}}, points, options), one);
}

TEST(Sum, APointAloneGoesTheSameWay) {
  Random random(94);
  for (const NamedSegment& named : whole_and_cut(random)) {
    const auto points = test::random_points(random, 70);
    for (const Precision precision : kPrecisions) {
      const std::vector<Vec3d> together = test::moved(Flow{{named.segment}}, points, options_of(precision));
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(test::moved(Flow{{named.segment}}, {points[i]}, options_of(precision))[0], together[i]) << named.name;
      }
    }
  }
}

TEST(Sum, ComesBackThroughItsInverseAndInPieces) {
  Random random(95);
  for (const NamedSegment& named : random_sums(random)) {
    const auto points = test::random_points(random, 100);
    const Flow flow{{named.segment}};
    const AdvectOptions options = options_of(Precision::float64, 1e-9);
    const std::vector<Vec3d> there = test::moved(flow, points, options);
    EXPECT_LT(
        test::greatest_distance(
            test::moved(flow_between(flow, 0.4, 1), test::moved(prefix(flow, 0.4), points, options), options), there),
        1e-6)
        << named.name;
    if (named.name == "limit cylinders") continue;  // which say nothing of where a point came from
    EXPECT_LT(test::greatest_distance(test::moved(inverse(flow), there, options), points), 1e-6) << named.name;
  }
}

TEST(Sum, KeepsTheVolumeAndKnowsItsJacobians) {
  Random random(96);
  for (const NamedSegment& named : random_sums(random)) {
    const Flow flow{{named.segment}};
    AdvectOptions options = options_of(Precision::float64, 1e-7);
    std::vector<Vec3d> points = test::random_points(random, 40);
    const std::vector<Mat3d> found = jacobians(flow, points, options);
    options.tolerance = 1e-10;
    std::vector<Vec3d> carried = points;
    const std::vector<double> drifts = volume_drifts(flow, carried, options);
    EXPECT_LT(test::greatest_distance(carried, test::moved(flow, points, options)), 1e-6) << named.name;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(determinant(found[i]), 1, 1e-5) << named.name;
      EXPECT_NEAR(drifts[i], 0, 1e-6) << named.name;
      if (named.name == "limit cylinders") continue;  // at whose walls the map jumps
      constexpr double kStep = 1e-4;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3d by{0, 0, 0};
        by[axis] = kStep;
        const std::vector<Vec3d> ends = test::moved(flow, {points[i] - by, points[i] + by}, options);
        const Vec3d column = (ends[1] - ends[0]) / (2 * kStep);
        const Vec3d expected{found[i].row0[axis], found[i].row1[axis], found[i].row2[axis]};
        EXPECT_LT(norm(column - expected), 2e-3) << named.name;
      }
    }
  }
}

TEST(Sum, APointThatMeetsOnePartAloneGoesAsInThatPart) {
  Random random(103);
  Segment sum = turn_and_image(70);
  for (Segment& part : sum.parts) std::get<Rotation<double>>(part.fields[0].motion).axis = {1, 0, 0};
  std::vector<Vec3d> points = test::random_points(random, 2000, 1.0);
  std::erase_if(points, [](const Vec3d& p) { return std::abs(p.x) < 0.41; });  // how far the other part goes
  const AdvectOptions options = options_of(Precision::float64);
  std::vector<Vec3d> moved = points;
  EXPECT_EQ(advect(Flow{{sum}}, moved, options).evaluations, 0U);  // closed forms
  EXPECT_GT(test::greatest_distance(moved, points), 0.3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Segment& part = sum.parts[points[i].x > 0 ? 0 : 1];
    EXPECT_EQ(moved[i], test::moved(Flow{{part}}, {points[i]}, options)[0]);
  }
}

TEST(Sum, APointThatTurnsIntoTheOtherPartIsMovedByBoth) {
  Random random(104);
  for (const double degrees : {35.0, -100.0, 170.0, 250.0}) {
    const Segment sum = turn_and_image(degrees);
    const auto points = test::random_points(random, 120, 1.0);
    const std::vector<Vec3d> moved = test::moved(Flow{{sum}}, points, options_of(Precision::float64, 1e-8));
    EXPECT_LT(test::greatest_distance(moved, by_small_steps(sum, points)), 1e-5) << degrees;
  }
}

TEST(Sum, OfPartsThatActApartIsThemOneAfterTheOther) {
  Random random(97);
  const Segment one = test::translating(Ball<double>{}, {0.5, 0, 0}, {0.1, 0.2, 0}, {0.1, 0.4});
  const Segment turn =
      test::resting(Rotation<double>{{0, 0, 1}, 1, 0, RotationGauge::radial}, Ball<double>{}, {-0.5, 0, 0}, {0.1, 0.4});
  const auto points = test::random_points(random, 3000, 1.0);
  for (const Precision precision : kPrecisions) {
    const Outcome apart = outcome_of(Flow{{sum_of({one, turn})}}, points, options_of(precision));
    EXPECT_EQ(apart, outcome_of(Flow{{one, turn}}, points, options_of(precision)));
  }
}

TEST(Sum, ALimitCylinderLimitsItsPartAlone) {
  Random random(98);
  const Rotation<double> bend{{0, 0, 1}, 0.5, 1};
  Segment right = test::resting(bend, HalfSpace<double>{{0, -1, 0}}, {0.5, 0, 0}, {-0.1, 0.1});
  right.limit_cylinder = LimitCylinder{{0.5, 0, 0}, {0, -1, 0}, 0.3};
  Segment left =
      test::resting(Rotation<double>{{0, 0, 1}, -0.5, 1}, HalfSpace<double>{{0, -1, 0}}, {-0.5, 0, 0}, {-0.1, 0.1});
  left.limit_cylinder = LimitCylinder{{-0.5, 0, 0}, {0, -1, 0}, 0.3};
  const auto points = test::random_points(random, 500, 1.0);
  const AdvectOptions options = options_of(Precision::float64);
  const std::vector<Vec3d> both = test::moved(Flow{{sum_of({left, right})}}, points, options);
  const std::vector<Vec3d> by_left = test::moved(Flow{{left}}, points, options);
  const std::vector<Vec3d> by_right = test::moved(Flow{{right}}, points, options);
  int count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(both[i], points[i].x < 0 ? by_left[i] : by_right[i]);
    count += both[i] == points[i] ? 0 : 1;
  }
  EXPECT_GT(count, 20);
}

TEST(Sum, ReachIsThatOfAllParts) {
  Random random(99);
  for (const NamedSegment& named : random_sums(random)) {
    const Flow flow{{named.segment}};
    const FlowSupport support(flow);
    const auto points = test::random_points(random, 500, 1.5);
    const std::vector<Vec3d> moved = test::moved(flow, points, options_of(Precision::float32));
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (support.may_move(points[i], 0)) continue;
      EXPECT_EQ(moved[i], points[i]) << named.name;
    }
  }
}

TEST(Sum, PointsOfAMirrorPlaneStayInItExactly) {
  Random random(100);
  Segment one = test::resting(Rotation<double>{{0.6, 0, 0.8}, 1, 0.3, RotationGauge::radial}, Ball<double>{},
                              {0.37, 0.1, 0}, {0.1, 0.7});
  Segment other = one;
  const double plane = 0.07;
  other.fields[0].center.x = 2 * plane - one.fields[0].center.x;
  other.fields[0].motion = Rotation<double>{{-0.6, 0, 0.8}, -1, 0.3, RotationGauge::radial};
  Segment sum = sum_of({one, other});
  sum.mirrored_at[0] = plane;
  auto points = test::random_points(random, 300);
  for (Vec3d& p : points) p.x = plane;
  for (const Precision precision : kPrecisions) {
    const std::vector<Vec3d> moved = test::moved(Flow{{sum}}, points, options_of(precision));
    EXPECT_GT(test::greatest_distance(moved, points), 0.01);
    for (const Vec3d& p : moved) EXPECT_EQ(p.x, plane);
  }
}

TEST(Sum, IsCheckedBeforeItMovesPoints) {
  const Segment one = test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8});
  const auto refuses = [](const Segment& segment) { EXPECT_THROW(validate(Flow{{segment}}), InvalidInput); };
  EXPECT_NO_THROW(validate(Flow{{sum_of({one, one})}}));
  refuses(sum_of({one}));
  refuses(sum_of(std::vector<Segment>(kMaxParts + 1, one)));
  refuses(sum_of({one, sum_of({one, one})}));
  Segment cut = one;
  cut.end = 0.5;
  refuses(sum_of({one, cut}));
  Segment with_field = sum_of({one, one});
  with_field.fields = one.fields;
  refuses(with_field);
  Random random(101);
  refuses(sum_of({one, test::pinning(random, 2, 0.8, 0.3)}));
  Segment mirrored = one;
  mirrored.mirrored_at[0] = 0;
  refuses(mirrored);
  Segment bad = one;
  bad.fields[0].center.x = std::nan("");
  refuses(sum_of({one, bad}));
}

}  // namespace
}  // namespace knead::sum_test
