// advect(): accuracy, untouched points, blocks, cancelling and errors.
#include "knead/flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <string>

#include "flow/block_mover.h"
#include "knead/error.h"
#include "knead/stroke.h"
#include "support/random_segments.h"

namespace knead::advect_test {
namespace {

using test::moved;
using test::NamedSegment;
using test::precisely;
using test::Random;

std::vector<std::uint64_t> bits(const std::vector<Vec3d>& points) {
  std::vector<std::uint64_t> result;
  for (const Vec3d& p : points) {
    for (const double x : {p.x, p.y, p.z}) result.push_back(std::bit_cast<std::uint64_t>(x));
  }
  return result;
}

// How much the flow magnifies an error made at the start: the norm of its Jacobian at each point, at least 1.
std::vector<double> stretches(const Flow& flow, const std::vector<Vec3d>& points) {
  const double h = 1e-5;
  std::vector<double> result(points.size(), 1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<Vec3d> low = points;
    std::vector<Vec3d> high = points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      low[i][axis] -= h;
      high[i][axis] += h;
    }
    low = moved(flow, low, precisely(1e-10));
    high = moved(flow, high, precisely(1e-10));
    for (std::size_t i = 0; i < points.size(); ++i) result[i] = std::fmax(result[i], norm(high[i] - low[i]) / (2 * h));
  }
  return result;
}

TEST(Advect, ForwardsThenBackwardsReturns) {
  Random random(61);
  for (const int falloff : {4, 4, 4, 4, 4, 4, 4, 4, 3, 5, 6, 7, kWideFalloff, kWideFalloff}) {
    for (const NamedSegment& named : test::random_segments(random, falloff)) {
      const Flow flow{{named.segment}};
      const auto points = test::random_points(random, 200);
      const auto there = moved(flow, points, precisely(1e-10));
      const auto back = moved(inverse(flow), there, precisely(1e-10));
      const auto stretch = stretches(inverse(flow), there);
      int far = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double error = norm(back[i] - points[i]) / stretch[i];
        if (error > 1e-8) ++far;
        EXPECT_LT(error, 1e-6) << named.name;  // some are stretched far more on the way than in all
      }
      EXPECT_LE(far, 10) << named.name;
    }
  }
}

// Every integrator, tolerance and precision, against a reference at 1e-11. An error made on the way is magnified by
// what is left of the flow, which the stretch over all of it stands for here.
TEST(Advect, ErrorStaysWithinTheTolerance) {
  Random random(62);
  for (const int falloff : {4, 4, 4, 3, 5, 6, 7, kWideFalloff, kWideFalloff}) {
    for (const NamedSegment& named : test::random_segments(random, falloff)) {
      const Flow flow{{named.segment}};
      const auto points = test::random_points(random, 200);
      const auto exact = moved(flow, points, precisely(1e-11));
      const auto stretch = stretches(flow, points);
      for (const Integrator integrator : {Integrator::rk4, Integrator::tsitouras}) {
        for (const double tolerance : {1e-4, 1e-5, 1e-6}) {
          for (const Precision precision : {Precision::float32, Precision::float64}) {
            AdvectOptions options = precisely(tolerance);
            options.integrator = integrator;
            options.precision = precision;
            const auto found = moved(flow, points, options);
            double worst = 0;
            for (std::size_t i = 0; i < points.size(); ++i) {
              worst = std::fmax(worst, norm(found[i] - exact[i]) / stretch[i]);
            }
            // Below 1e-5 of the size float's rounding is as large.
            const double bar = precision == Precision::float32 ? std::fmax(tolerance, 1e-5) + 3e-6 : tolerance;
            EXPECT_LT(worst, 1.5 * bar) << named.name << ", integrator " << static_cast<int>(integrator)
                                        << ", tolerance " << tolerance << ", falloff " << falloff;
          }
        }
      }
    }
  }
}

// The bar of the method, section 3: a segment and the same segment cut into 50 differ by at most ten tolerances. Tools
// that sweep far past the points, so that most contacts graze.
TEST(Advect, OneSegmentEqualsTheSameCutIntoFiftyWhereItGrazes) {
  Random random(63);
  double worst = 0;
  for (const int falloff : {4, 4, 4, 4, 4, 4, 3, 5, 6, 7}) {
    const double outer = random.uniform(0.1, 0.4);
    const Thresholds<double> thresholds{outer * random.uniform(0.05, 0.8), outer, falloff};
    const Vec3d by{random.uniform(2, 4), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)};
    const Vec3d start{-2, 0, 0};
    const std::vector<Segment> sweeps = {
        test::translating(Ball<double>{}, start, by, thresholds),
        test::translating(Capsule<double>{random.in_box(0.3)}, start, by, thresholds),
        test::translating(PointSet<double>{{random.in_box(0.3), random.in_box(0.3)}, {}, 8}, start, by, thresholds),
        test::translating(PointSet<double>{{}, {{random.in_box(0.3), random.in_box(0.3), random.in_box(0.3)}}, 8},
                          start, by, thresholds)};
    std::vector<Vec3d> points;
    for (int i = 0; i < 1000; ++i) {
      // Near the rim of what the ball sweeps.
      const double angle = random.uniform(0, 6.3);
      const double radius = outer * (i % 2 == 0 ? random.uniform(0.9, 1.001) : random.uniform(0, 1.4));
      points.push_back(start + by * random.uniform(-0.1, 1.1) + Vec3d{0, std::cos(angle), std::sin(angle)} * radius);
    }
    for (const Segment& segment : sweeps) {
      Flow cut;
      for (int i = 0; i < 50; ++i) {
        Segment piece = segment;
        piece.begin = i / 50.0;
        piece.end = (i + 1) / 50.0;
        cut.segments.push_back(piece);
      }
      for (const double tolerance : {1e-5, 1e-6}) {
        const auto whole = moved(Flow{{segment}}, points, precisely(tolerance));
        const auto pieces = moved(cut, points, precisely(tolerance));
        worst = std::fmax(worst, test::greatest_distance(whole, pieces) / tolerance);
      }
    }
  }
  EXPECT_LT(worst, 10);
  RecordProperty("worst_in_tolerances", std::to_string(worst));
}

TEST(Advect, PointsThatNoToolTouchesKeepTheirBits) {
  Random random(64);
  for (int round = 0; round < 10; ++round) {
    for (const NamedSegment& named : test::random_segments(random)) {
      if (std::holds_alternative<HalfSpace<double>>(named.segment.fields[0].region)) continue;
      for (const Precision precision : {Precision::float32, Precision::float64}) {
        auto points = test::random_points(random, 300, 3.0);
        points.push_back({-0.0, 30.0, -0.0});  // a negative zero is a bit pattern too
        AdvectOptions options = precisely(1e-5);
        options.precision = precision;
        const auto after = moved(Flow{{named.segment}}, points, options);
        for (std::size_t i = 0; i < points.size(); ++i) {
          bool outside = true;
          for (const Field& field : named.segment.fields) {
            for (int k = 0; k <= 100; ++k) {
              const Vec3d d = points[i] - field.center - displacement_of(named.segment, field) * (k / 100.0);
              outside = outside && region_value(field, d).value > field.thresholds.outer * 1.01;
            }
          }
          if (outside) {
            EXPECT_EQ(bits({after[i]}), bits({points[i]})) << named.name;
          }
        }
      }
    }
  }
}

TEST(Advect, PointsOfTheRigidCoreMoveExactlyWithTheTool) {
  Random random(65);
  for (int round = 0; round < 50; ++round) {
    const Vec3d c = random.in_box(5);
    const Vec3d by = random.in_box(1);
    const Flow flow{{test::translating(Ball<double>{}, c, by, {0.5, 0.7})}};
    std::vector<Vec3d> points;
    std::vector<Vec3d> expected;
    for (int i = 0; i < 50; ++i) {
      points.push_back(c + random.unit() * random.uniform(0, 0.4999));
      expected.push_back(points.back() + by);
    }
    EXPECT_EQ(bits(moved(flow, points, test::in_float())), bits(expected));
  }
}

TEST(Advect, DoesNotDependOnThreadsNorOnTheOrderOfThePoints) {
  Random random(66);
  Flow flow;
  for (const NamedSegment& named : test::random_segments(random)) flow.segments.push_back(named.segment);
  const auto points = test::random_points(random, 5000);
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(66));
  std::vector<Vec3d> shuffled;
  for (const std::size_t i : order) shuffled.push_back(points[i]);
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    AdvectOptions options = precisely(1e-5);
    options.precision = precision;
    options.threads = 1;
    const auto one = moved(flow, points, options);
    options.threads = 2;
    EXPECT_EQ(bits(moved(flow, points, options)), bits(one));
    const auto permuted = moved(flow, shuffled, options);
    for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(bits({permuted[i]}), bits({one[order[i]]}));
  }
}

// The tool, the points and the path far from the origin: the displacement is that near the origin, up to the rounding
// of the positions themselves.
TEST(Advect, FloatEvaluationDoesNotMindPositionsFarFromTheOrigin) {
  Random random(67);
  const Vec3d far{1000, -2000, 500};
  const Segment near_segment = test::translating(Ball<double>{}, {0, 0, 0}, {0.3, 0.1, 0}, {0.2, 0.8});
  Segment far_segment = near_segment;
  far_segment.fields[0].center = far;
  auto near = test::random_points(random, 500);
  std::vector<Vec3d> away;
  for (Vec3d& p : near) {
    away.push_back(p + far);
    p = away.back() - far;
  }
  const AdvectOptions options = test::in_float();
  const auto near_moved = moved(Flow{{near_segment}}, near, options);
  const auto far_moved = moved(Flow{{far_segment}}, away, options);
  double worst = 0;
  for (std::size_t i = 0; i < near.size(); ++i) worst = std::fmax(worst, norm(far_moved[i] - far - near_moved[i]));
  EXPECT_LT(worst, 1e-12);
}

TEST(Advect, CylinderMovesOnlyWhatIsWithinItAtTheStart) {
  Random random(68);
  Segment bend = test::resting(Rotation<double>{{0, 0, 1}, 1.2, 1}, HalfSpace<double>{{1, 0, 0}, {0, 0, 1}, 0.6},
                               {0, 0, 0}, {-0.3, 0.3});
  const auto points = test::random_points(random, 2000);
  const auto free = moved(Flow{{bend}}, points, precisely());
  bend.limit_cylinder = LimitCylinder{{0, 0, 0}, {1, 0, 0}, 0.4};
  const Flow flow{{bend}};
  const auto restricted = moved(flow, points, precisely());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool within = std::hypot(points[i].y, points[i].z) <= 0.4;
    EXPECT_EQ(restricted[i], within ? free[i] : points[i]);
  }
  // Backwards: what came from within the limit cylinder is taken back to where it was.
  const auto back = moved(inverse(flow), restricted, precisely());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::hypot(points[i].y, points[i].z) < 0.399) {
      EXPECT_LT(norm(back[i] - points[i]), 1e-8);
    }
  }
  // The second half alone asks where the points were at the start, too.
  Segment first = bend;
  first.end = 0.5;
  Segment second = bend;
  second.begin = 0.5;
  std::vector<Vec3d> inside;
  for (const Vec3d& p : points) {
    if (std::hypot(p.y, p.z) < 0.399) inside.push_back(p);
  }
  EXPECT_LT(
      test::greatest_distance(moved(Flow{{first, second}}, inside, precisely()), moved(flow, inside, precisely())),
      1e-8);
}

TEST(Advect, CountsStepsPerPointAndReportsProgress) {
  Random random(69);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8}),
                   test::translating(Ball<double>{}, {0.5, 0, 0}, {0, 0.5, 0}, {0.1, 0.8})}};
  auto points = test::random_points(random, 3000);
  std::vector<std::uint32_t> steps(points.size(), 7);
  Progress progress;
  AdvectOptions options = precisely(1e-6);
  options.steps = steps;
  options.progress = &progress;
  const AdvectResult result = advect(flow, points, options);
  std::uint64_t sum = 0;
  for (const std::uint32_t s : steps) sum += s - 7;
  EXPECT_EQ(sum, result.accepted_steps);
  EXPECT_GT(result.accepted_steps, 3000U);
  EXPECT_GE(result.evaluations, 6 * (result.accepted_steps + result.rejected_steps));
  EXPECT_EQ(progress.done, 6000U);
}

TEST(Advect, StopsWhenCancelled) {
  Random random(70);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8})}};
  auto points = test::random_points(random, 3000);
  Progress progress;
  progress.cancel = true;
  AdvectOptions options = precisely(1e-6);
  options.progress = &progress;
  EXPECT_EQ(advect(flow, points, options).status, AdvectStatus::cancelled);
}

// A path line that turns through many radians needs thousands of steps. Each is a chance to stop.
TEST(Advect, StopsInTheMiddleOfAPathLine) {
  constexpr int kUntil = 5000;
  std::atomic<int> calls{0};
  Progress progress;
  const CustomRegion region = custom_region([&](const Vec3d& d, double) {
    if (++calls == kUntil) progress.cancel = true;
    return RegionValue<double>{norm(d), d / norm(d)};
  });
  const Rotation<double> turn{{0, 0, 1}, 1000};
  const Flow flow{{test::resting(turn, region, {0, 0, 0}, {0.1, 0.8})}};
  AdvectOptions options = precisely(1e-9);
  options.threads = 1;
  std::vector<Vec3d> points;
  for (int i = 0; i < 64; ++i) points.push_back({0.5 * std::cos(0.1 * i), 0.5 * std::sin(0.1 * i), 0.01 * i});
  advect(flow, points, options);
  EXPECT_GT(calls, 20 * kUntil);  // uninterrupted

  calls = 0;
  progress.cancel = false;
  options.progress = &progress;
  const std::vector<Vec3d> before = points;
  EXPECT_EQ(advect(flow, points, options).status, AdvectStatus::cancelled);
  EXPECT_LT(calls, 2 * kUntil);
  EXPECT_EQ(bits(points), bits(before));
}

// Whatever the threads: the exact number suffices, and one less does not. Pins are moved in pieces.
TEST(Advect, WithinABoundOnEvaluationsIsTheSameOrNothing) {
  Random random(71);
  for (const NamedSegment& named : test::random_segments(random)) {
    SCOPED_TRACE(named.name);
    const Segment segment = test::without_closed_form(named.segment);
    const Flow flow{{segment, segment}};
    const std::vector<Vec3d> points = test::random_points(random, 3000);
    AdvectOptions options = test::in_float();
    std::vector<Vec3d> expected = points;
    const std::uint64_t needed = advect(flow, expected, options).evaluations;
    ASSERT_GT(needed, 0U);
    for (const int threads : {1, 3}) {
      options.threads = threads;
      detail::ReadyFlow ready(flow, options);
      for (const std::uint64_t most : {needed - 1, needed, needed, needed - 1}) {
        std::vector<Vec3d> moved = points;
        const bool is_enough = most == needed;
        EXPECT_EQ(detail::advect_within(ready, moved, most).status,
                  is_enough ? AdvectStatus::done : AdvectStatus::step_limit);
        EXPECT_EQ(bits(moved), bits(is_enough ? expected : points));
      }
    }
  }
}

TEST(Advect, EndsSoonAfterTheBoundOnEvaluations) {
  constexpr std::uint64_t kMax = 100'000;
  const Rotation<double> turn{{0, 0, 1}, 10'000};
  const Flow flow{{test::resting(turn, Ball<double>{}, {0, 0, 0}, {0.1, 0.8})}};
  std::vector<Vec3d> points(1000, Vec3d{0.5, 0, 0});
  AdvectOptions options = precisely(1e-6);
  EXPECT_GT(advect(flow, points, options).evaluations, 100 * kMax);
  options.threads = 1;
  detail::ReadyFlow ready(flow, options);
  const AdvectResult ended = detail::advect_within(ready, points, kMax);
  EXPECT_EQ(ended.status, AdvectStatus::step_limit);
  EXPECT_LT(ended.evaluations, 2 * kMax);
}

std::string refusal(const Flow& flow, std::vector<Vec3d> points) {
  try {
    advect(flow, points, test::in_float());
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Advect, RefusesPointsThatAreNotFinite) {
  const Segment good = test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8});
  for (const std::size_t segments : {1U, 8U}) {  // few and many: points in their order, and sorted
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<Vec3d> points(300);
        points[217][axis] = bad;
        const Flow flow{std::vector<Segment>(segments, good)};
        EXPECT_EQ(refusal(flow, points), "point 217 has a coordinate that is not finite; place or remove it");
      }
    }
  }
}

TEST(Advect, RefusesWhatMeansNothing) {
  std::vector<Vec3d> points(1);
  AdvectOptions options;
  const Segment good = test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8});
  for (const double tolerance : {options.tolerance, -1e-5, std::nan(""), HUGE_VAL}) {
    options.tolerance = tolerance;
    EXPECT_THROW(advect(Flow{{good}}, points, options), InvalidInput) << tolerance;
  }
  options = test::in_float();
  Segment bad = good;
  bad.fields[0].thresholds = {0.8, 0.8};
  EXPECT_THROW(advect(Flow{{bad}}, points, options), InvalidInput);
  std::vector<std::uint32_t> steps(2);
  options.steps = steps;
  EXPECT_THROW(advect(Flow{{good}}, points, options), InvalidInput);
}

TEST(Advect, AToleranceIsALengthThatDependsOnTheShapesSize) {
  EXPECT_EQ(absolute_tolerance(1e-5, 200), 1e-5 * 200);
  for (const double bad : {0.0, -1e-5, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(absolute_tolerance(bad, 1), InvalidInput) << bad;
    EXPECT_THROW(absolute_tolerance(1e-5, bad), InvalidInput) << bad;
  }
  EXPECT_THROW(absolute_tolerance(1e-200, 1e-200), InvalidInput);
}

// Beside the axis of a bend the turning plane is all but at rest when the stroke begins; a path line that looks short
// there is not.
TEST(Advect, AToolThatIsSlowAtItsBeginningIsNotTakenForOneAtRest) {
  BendStroke bend;
  bend.axis = {0, 0, 1};
  bend.normal = {-1, 0, 0};
  bend.angle_deg = 90;
  bend.extent = BendWidth{2};
  const Flow flow = flow_of(bend);
  std::vector<Vec3d> points;
  for (int i = 0; i <= 40; ++i) {
    for (const double y : {0.0, 1e-9, 1e-4}) points.push_back({-1.05 + 0.005 * i, y, -0.5});
  }
  const std::vector<Vec3d> exact = moved(flow, points, precisely(1e-11));
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    AdvectOptions options;
    options.tolerance = 1e-5;
    options.precision = precision;
    const std::vector<Vec3d> found = moved(flow, points, options);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LT(norm(found[i] - exact[i]), 1e-5) << points[i].x << " " << points[i].y;
    }
  }
}

}  // namespace
}  // namespace knead::advect_test
