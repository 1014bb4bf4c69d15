// What advect gives is the same, bit for bit, whatever it is computed with and however the points lie.
#include "knead/flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/outcome.h"
#include "support/random_segments.h"

namespace knead::simd_test {
namespace {

using test::NamedSegment;
using test::Outcome;
using test::outcome_of;
using test::Random;
using test::Simd;

constexpr Integrator kIntegrators[] = {Integrator::rk4, Integrator::tsitouras};
constexpr Precision kPrecisions[] = {Precision::float32, Precision::float64};

// Every kind of segment: whole, a part of it, and both backwards; those that have a limit cylinder with and without
// one.
std::vector<NamedSegment> all_segments(Random& random) {
  std::vector<NamedSegment> result;
  for (const NamedSegment& whole : test::random_segments(random)) {
    std::vector<NamedSegment> kinds{whole};
    if (std::holds_alternative<HalfSpace<double>>(whole.segment.fields[0].region)) {
      kinds.push_back(whole);
      kinds.back().name += " in a limit cylinder";
      kinds.back().segment.limit_cylinder = LimitCylinder{random.in_box(0.1), random.unit(), 0.4};
    }
    for (const NamedSegment& kind : kinds) {
      for (const auto& [begin, end] : {std::pair{0.0, 1.0}, {1.0, 0.0}, {0.25, 0.8}, {0.7, 0.1}, {0.5, 0.505}}) {
        result.push_back(kind);
        result.back().name += " from " + std::to_string(begin) + " to " + std::to_string(end);
        result.back().segment.begin = begin;
        result.back().segment.end = end;
      }
    }
  }
  return result;
}

Flow flow_of_all(Random& random) {
  Flow flow;
  for (const NamedSegment& named : test::random_segments(random)) flow.segments.push_back(named.segment);
  return flow;
}

AdvectOptions options_of(Precision precision, double tolerance = 1e-5) {
  AdvectOptions options = test::precisely(tolerance);
  options.precision = precision;
  return options;
}

std::vector<std::size_t> shuffled(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  return order;
}

TEST(Simd, EveryInstructionSetGivesTheSameBits) {
  Random random(81);
  const auto names = test::simd_names();
  const auto segments = all_segments(random);
  for (const NamedSegment& named : segments) {
    const auto points = test::random_points(random, 331);
    for (const Integrator integrator : kIntegrators) {
      for (const Precision precision : kPrecisions) {
        AdvectOptions options = options_of(precision);
        options.integrator = integrator;
        std::vector<Outcome> outcomes;
        for (const std::string& name : names) {
          const Simd simd(name);
          outcomes.push_back(outcome_of(Flow{{named.segment}}, points, options));
          EXPECT_EQ(outcomes.back(), outcomes.front())
              << named.name << ", " << name << ", integrator " << static_cast<int>(integrator);
        }
      }
    }
  }
}

TEST(Simd, EveryInstructionSetGivesTheSameBitsForEveryFalloff) {
  Random random(83);
  const auto names = test::simd_names();
  for (const int falloff : test::kOtherFalloffs) {
    for (const NamedSegment& named : test::random_segments(random, falloff)) {
      const auto points = test::random_points(random, 331);
      for (const Precision precision : kPrecisions) {
        std::vector<Outcome> outcomes;
        for (const std::string& name : names) {
          const Simd simd(name);
          outcomes.push_back(outcome_of(Flow{{named.segment}}, points, options_of(precision)));
          EXPECT_EQ(outcomes.back(), outcomes.front()) << named.name << ", " << name << ", falloff " << falloff;
        }
      }
    }
  }
}

TEST(Simd, NamesWhatIsInUse) {
  for (const std::string& name : test::simd_names()) {
    const Simd simd(name);
    EXPECT_EQ(simd_name(), name);
  }
  const Simd none("");
  EXPECT_EQ(simd_name(), test::simd_names().back());  // the widest
}

TEST(Simd, RefusesWhatTheMachineDoesNotHave) {
  const Simd simd("sse9");
  EXPECT_THROW(simd_name(), InvalidInput);
  std::vector<Vec3d> points(1);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8})}};
  EXPECT_THROW(advect(flow, points, test::in_float()), InvalidInput);
}

TEST(OneHash, ThreadsAndTheOrderOfThePointsDoNotMatter) {
  Random random(82);
  const Flow flow = flow_of_all(random);
  const auto points = test::random_points(random, 9001);
  const auto order = shuffled(points.size());
  std::vector<Vec3d> permuted;
  permuted.reserve(order.size());
  for (const std::size_t i : order) permuted.push_back(points[i]);
  for (const Precision precision : kPrecisions) {
    AdvectOptions options = options_of(precision);
    options.threads = 1;
    const Outcome one = outcome_of(flow, points, options);
    for (const int threads : {2, 7}) {
      options.threads = threads;
      EXPECT_EQ(outcome_of(flow, points, options), one) << threads << " threads";
    }
    Outcome other = outcome_of(flow, permuted, options);
    const Outcome as_it_came = other;
    for (std::size_t i = 0; i < order.size(); ++i) {
      other.steps[order[i]] = as_it_came.steps[i];
      std::copy_n(as_it_came.points.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                  other.points.begin() + static_cast<std::ptrdiff_t>(3 * order[i]));
    }
    EXPECT_EQ(other, one);
  }
}

// The flow whole or a segment at a time, in blocks that were sorted or left as given, with points that are now and then
// brought up to date while other groups have not been reached yet.
TEST(OneHash, BlocksDoNotMatter) {
  Random random(83);
  Flow flow = flow_of_all(random);
  for (const Segment& back : inverse(flow).segments) flow.segments.push_back(back);
  const auto points = test::random_points(random, 5000, 1.2);
  for (const Precision precision : kPrecisions) {
    const Outcome whole = outcome_of(flow, points, options_of(precision));
    for (const auto order : {PointBlocks::Order::sorted, PointBlocks::Order::given}) {
      PointBlocks blocks(points, order);
      Outcome outcome;
      std::vector<Vec3d> moved = points;
      for (std::size_t i = 0; i < flow.segments.size(); ++i) {
        outcome += advect(Flow{{flow.segments[i]}}, blocks, moved, options_of(precision));
        if (i % 3 == 0) blocks.update(moved);
      }
      blocks.update(moved);
      outcome.points = test::bits(moved);
      outcome.steps = blocks.steps();
      EXPECT_EQ(outcome, whole);
    }
  }
}

// Random points, and some where a region begins or ends, to the last bits.
std::vector<Vec3d> points_about(Random& random, const Segment& segment, int count) {
  auto points = test::random_points(random, count);
  const Field& field = segment.fields.front();
  for (int i = 0; i < count; ++i) {
    const Vec3d at = field.center + segment.displacement * (i % 3 == 0 ? segment.end : segment.begin);
    points.push_back(at + random.unit() * (i % 2 == 0 ? field.thresholds.inner : field.thresholds.outer));
  }
  return points;
}

// So neither the number of points that are integrated side by side matters, nor the size of blocks.
TEST(OneHash, PointsAloneGoTheSameWayAsTogether) {
  Random random(84);
  std::vector<NamedSegment> segments;
  for (int round = 0; round < 3; ++round) {
    for (const NamedSegment& named : all_segments(random)) segments.push_back(named);
  }
  for (const NamedSegment& named : segments) {
    const Flow flow{{named.segment}};
    const auto points = points_about(random, named.segment, 100);
    for (const Precision precision : kPrecisions) {
      const AdvectOptions options = options_of(precision);
      const Outcome together = outcome_of(flow, points, options);
      Outcome alone;
      for (const Vec3d& x : points) {
        const Outcome one = outcome_of(flow, {x}, options);
        alone.points.insert(alone.points.end(), one.points.begin(), one.points.end());
        alone.steps.push_back(one.steps.front());
        alone += {one.status, one.accepted, one.rejected, one.evaluations};
      }
      EXPECT_EQ(alone, together) << named.name;
    }
  }
}

}  // namespace
}  // namespace knead::simd_test
