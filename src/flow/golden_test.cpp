// The bits that every build gives: each compiler, each optimisation, each instruction set. Where they change, results
// of users change: renew the numbers below only where that is meant, and say so in the changelog.
#include <gtest/gtest.h>

#include <sstream>

#include "knead/flow.h"
#include "support/outcome.h"

namespace knead::golden_test {
namespace {

// Numbers in [-1, 1) from integers alone.
class Integers {
 public:
  double next() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(static_cast<std::int64_t>(state_ >> 40) - (std::int64_t{1} << 23)) / (1 << 23);
  }
  Vec3d vector() {
    const double x = next();
    const double y = next();
    const double z = next();
    return {x, y, z};
  }

 private:
  std::uint64_t state_ = 1;
};

Segment segment_of(const Motion& motion, const Region& region, Thresholds<double> thresholds,
                   const Vec3d& displacement = {}) {
  Segment segment;
  segment.fields = {{{0.125, -0.0625, 0.03125}, motion, region, thresholds}};
  segment.displacement = displacement;
  return segment;
}

// One of everything; unit vectors of fractions that are exact, or nearly.
Flow scene() {
  const Vec3d by{0.375, 0.25, -0.125};
  const Vec3d axis{0, 0.6, 0.8};
  const Vec3d normal{1, 0, 0};
  const Translation<double> along{by};
  const Mat3d squash{{-0.25, 0, 0}, {0, 0.5, 0}, {0, 0, -0.25}};
  const Mat3d shear{{0.125, 0.5, 0}, {0, -0.25, 0.25}, {0.125, 0, 0.125}};
  const PointSet<double> eight{{{0.5, 0, 0},
                                {0, 0.5, 0},
                                {0, 0, 0.5},
                                {-0.5, 0, 0},
                                {0, -0.5, 0},
                                {0, 0, -0.5},
                                {0.25, 0.25, 0},
                                {0, -0.25, 0.25}},
                               {},
                               8};
  const PointSet<double> curve{{{0.5, 0.5, 0}}, {{{-0.5, 0, 0}, {0, 0.25, 0}, {0.5, 0, 0.25}}}, 6};
  PointSet<double> many;
  Integers integers;
  for (int i = 0; i < 200; ++i) many.points.push_back(integers.vector() * 0.5);
  Handles<double> handles{{{{0.5, 0, 0}, {0.5, 0.25, 0}}, {}, 4}, {{{-0.5, 0, 0}}, {}, 4}};
  handles.sweep = by;
  const Thresholds<double> ball{0.25, 0.875};
  const Thresholds<double> slab{-0.375, 0.5};
  Flow flow;
  flow.segments = {
      segment_of(along, Ball<double>{}, ball, by),
      segment_of(along, Ball<double>{}, {0, 0.5}, by),
      segment_of(Translation<double>{by, normal, 0}, Capsule<double>{{0.25, 0, 0}}, ball, by),
      segment_of(along, eight, {0.0625, 0.5}, by),
      segment_of(along, curve, {0.0625, 0.5}, by),
      segment_of(along, many, {0.0625, 0.375}, by * 0.25),
      segment_of(along, handles, {0, 1}, by),
      segment_of(Rotation<double>{axis, 1.25, 0.5, RotationGauge::radial}, Ball<double>{}, ball),
      segment_of(Rotation<double>{axis, 0.75, 1}, Capsule<double>{{0.25, 0, 0}}, ball),
      segment_of(Strain<double>{squash}, Ball<double>{}, ball),
      segment_of(Strain<double>{shear}, Ball<double>{}, ball),
      segment_of(Twist<double>{axis, 0.75, 0.5}, HalfSpace<double>{axis}, slab),
      segment_of(Twist<double>{axis, 0.5, 0.5}, HalfSpace<double>{normal}, slab),
      segment_of(Rotation<double>{axis, 0.5, 1}, HalfSpace<double>{normal, axis, 0.25}, slab),
  };
  flow.segments.push_back(flow.segments.front());
  flow.segments.back().time_law = TimeLaw::blended;
  flow.segments.push_back(flow.segments.front());
  flow.segments.back().fields.push_back(flow.segments[2].fields.front());
  flow.segments.push_back(flow.segments[13]);
  flow.segments.back().limit_cylinder = LimitCylinder{{0, 0, 0}, axis, 0.5};
  return flow;
}

// Of the points after each segment alone, from its beginning to its end and the other way, the steps and the counts.
std::uint64_t hash_in(Precision precision, Integrator integrator) {
  Integers integers;
  std::vector<Vec3d> points;
  for (int i = 0; i < 200; ++i) points.push_back(integers.vector());
  AdvectOptions options;
  options.tolerance = 1e-5;
  options.precision = precision;
  options.integrator = integrator;
  std::vector<std::uint64_t> numbers;
  const Flow forwards = scene();
  for (const Flow& flow : {forwards, inverse(forwards)}) {
    for (const Segment& segment : flow.segments) {
      const test::Outcome outcome = test::outcome_of(Flow{{segment}}, points, options);
      EXPECT_EQ(outcome.status, AdvectStatus::done);
      numbers.insert(numbers.end(), outcome.points.begin(), outcome.points.end());
      numbers.insert(numbers.end(), outcome.steps.begin(), outcome.steps.end());
      numbers.insert(numbers.end(), {outcome.accepted, outcome.rejected, outcome.evaluations});
    }
  }
  return test::hash(numbers);
}

struct Golden {
  Precision precision = Precision::float32;
  Integrator integrator = Integrator::rk4;
  std::string hash;
};

TEST(GoldenHash, IsThatOfEveryBuild) {
  const std::vector<Golden> expected = {
      {Precision::float32, Integrator::rk4, "b42c3fb1d4a9ecba"},
      {Precision::float64, Integrator::rk4, "a89af58cee502e9f"},
      {Precision::float32, Integrator::tsitouras, "c3f545226ddaed5a"},
      {Precision::float64, Integrator::tsitouras, "4953304fd250764"},
  };
  for (const std::string& name : test::simd_names()) {
    const test::Simd simd(name);
    for (const Golden& golden : expected) {
      std::ostringstream found;
      found << std::hex << hash_in(golden.precision, golden.integrator);
      EXPECT_EQ(found.str(), golden.hash) << name << ", integrator " << static_cast<int>(golden.integrator);
    }
  }
}

}  // namespace
}  // namespace knead::golden_test
