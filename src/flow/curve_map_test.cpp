// Tests of the map of a curve's surroundings: volume, there and back, the velocity, rigid ends, parts, bits.
#include "flow/curve_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/stroke.h"
#include "support/random_fields.h"

namespace knead::curve_map_test {

namespace {

using detail::CurvePoint;
using detail::CurveTable;
using test::Random;

// A segment whose curve turns both ways, twists and stretches. The greatest curvature is about 6 / size.
Segment random_curve(Random& random, double size, bool is_straight) {
  Segment segment;
  CurveMotion& curve = segment.curve;
  curve.length = size;
  std::vector<CurveNode> nodes(static_cast<std::size_t>(random.uniform(13, 33)));
  const double first = random.uniform(-4, 4) / size;
  const double second = is_straight ? 0 : random.uniform(-1, 1) / size;
  const double phase = random.uniform(0, 6);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(nodes.size());
    nodes[i] = {{second * std::sin(3 * x), second * std::cos(4 * x + phase)},
                {first * std::cos(phase * x), first * std::sin(2 * phase * x)},
                random.uniform(0, 2) / size,
                random.uniform(-0.3, 0.4)};
  }
  curve.nodes = SharedList<CurveNode>(std::move(nodes));
  curve.anchor = static_cast<int>(random.uniform(0, curve.intervals() + 0.9));
  curve.place = random.in_box(size);
  const Vec3d tangent = normalized(random.in_box(1));
  const Vec3d across = any_orthogonal(tangent);
  curve.frame = {tangent, across, cross(tangent, across)};
  curve.shift = random.in_box(size);
  curve.turn = random.in_box(1);
  return segment;
}

// Lets the stretch go on beyond the last end, of every second curve in one direction across only.
void stretch_to_the_end(Segment& segment, Random& random, bool one_across) {
  segment.curve.end_stretch = random.uniform(-0.6, 2);
  segment.curve.one_across = one_across;
  std::vector<CurveNode> nodes(segment.curve.nodes.begin(), segment.curve.nodes.end());
  for (CurveNode& node : nodes) node.twist = one_across ? 0 : node.twist;
  segment.curve.nodes = SharedList<CurveNode>(std::move(nodes));
}

// Places about the curve and beyond its ends, at t = 0.
std::vector<Vec3d> places_about(const Segment& segment, Random& random, std::size_t count) {
  const CurveTable<double> table(segment.curve, 0.0);
  const double size = segment.curve.length;
  std::vector<Vec3d> places(count);
  for (Vec3d& x : places) {
    const CurvePoint<double> at{random.uniform(-0.5, 1.5) * size,
                                {random.uniform(-0.04, 0.04) * size, random.uniform(-0.04, 0.04) * size}};
    EXPECT_TRUE(table.place(at, x));
    x += segment.curve.place;
  }
  return places;
}

AdvectOptions options_of(double size) {
  AdvectOptions options;
  options.tolerance = 1e-5 * size;
  return options;
}

std::vector<Vec3d> moved(const Flow& flow, std::vector<Vec3d> points, double size) {
  EXPECT_EQ(advect(flow, points, options_of(size)).status, AdvectStatus::done);
  return points;
}

// Sizes from 1e-3 to 1e3.
double size_of(int curve) { return std::pow(10.0, curve % 7 - 3); }

}  // namespace

TEST(CurveMap, KeepsTheVolumeExactly) {
  Random random(1);
  for (int i = 0; i < 10; ++i) {
    Segment segment = random_curve(random, size_of(i), i % 2 == 0);
    if (i > 4) stretch_to_the_end(segment, random, i % 4 < 2);
    const std::vector<Vec3d> places = places_about(segment, random, 10'000);
    for (const Mat3d& j : jacobians({{segment}}, places, options_of(size_of(i)))) {
      ASSERT_NEAR(determinant(j), 1, 1e-10);
    }
  }
}

TEST(CurveMap, GoesThereAndBackAlsoInParts) {
  Random random(2);
  for (int i = 0; i < 10; ++i) {
    const double size = size_of(i);
    Flow flow{{random_curve(random, size, i % 2 == 0)}};
    flow.segments[0].curve.keeps_thickness = i % 3 == 0;
    flow.segments[0].curve.keeps_length = i % 3 == 1;
    if (i > 4) stretch_to_the_end(flow.segments[0], random, i % 4 < 2);
    const std::vector<Vec3d> places = places_about(flow.segments[0], random, 1000);
    const std::vector<Vec3d> there = moved(flow, places, size);
    const std::vector<Vec3d> half = moved(flow_between(flow, 0, 0.4), places, size);
    const std::vector<Vec3d> whole = moved(flow_between(flow, 0.4, 1), half, size);
    const std::vector<Vec3d> back = moved(inverse(flow), there, size);
    for (std::size_t k = 0; k < places.size(); ++k) {
      ASSERT_LE(norm(back[k] - places[k]), 1e-10 * size);
      ASSERT_LE(norm(whole[k] - there[k]), 1e-10 * size);
    }
  }
}

TEST(CurveMap, IsTheFlowOfItsVelocity) {
  Random random(3);
  Segment segment = random_curve(random, 1, false);
  stretch_to_the_end(segment, random, true);
  const std::vector<Vec3d> places = places_about(segment, random, 20);
  const std::vector<Vec3d> there = moved({{segment}}, places, 1);
  std::vector<Vec3d> x = places;
  constexpr int kSteps = 500;  // of the classical Runge-Kutta method
  const auto after = [&](const std::vector<Vec3d>& k, double step) {
    std::vector<Vec3d> result = x;
    for (std::size_t i = 0; i < x.size(); ++i) result[i] += k[i] * step;
    return result;
  };
  constexpr double kStep = 1.0 / kSteps;
  for (int step = 0; step < kSteps; ++step) {
    const auto velocity = [&](const std::vector<Vec3d>& points, double share) {
      return velocities({{segment}}, points, std::min(1.0, (step + share) * kStep));
    };
    const std::vector<Vec3d> k1 = velocity(x, 0);
    const std::vector<Vec3d> k2 = velocity(after(k1, 0.5 * kStep), 0.5);
    const std::vector<Vec3d> k3 = velocity(after(k2, 0.5 * kStep), 0.5);
    const std::vector<Vec3d> k4 = velocity(after(k3, kStep), 1);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += (k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i]) * (kStep / 6);
  }
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LE(norm(x[i] - there[i]), 1e-9);
}

TEST(CurveMap, HasTheJacobianOfDifferences) {
  Random random(4);
  Segment segment = random_curve(random, 1, true);
  stretch_to_the_end(segment, random, false);
  for (const int keeps : {0, 1, 2}) {
    segment.curve.keeps_thickness = keeps == 1;
    segment.curve.keeps_length = keeps == 2;
    const std::vector<Vec3d> places = places_about(segment, random, 200);
    const std::vector<Mat3d> all = jacobians({{segment}}, places, options_of(1));
    constexpr double kStep = 1e-6;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<Vec3d> before = places;
      std::vector<Vec3d> after = places;
      for (Vec3d& x : before) x[axis] -= kStep;
      for (Vec3d& x : after) x[axis] += kStep;
      before = moved({{segment}}, before, 1);
      after = moved({{segment}}, after, 1);
      for (std::size_t i = 0; i < places.size(); ++i) {
        EXPECT_LE(norm((after[i] - before[i]) / (2 * kStep) - all[i].column(axis)), 1e-6);
      }
    }
  }
}

// Distances beyond the ends stay; what is beyond an end that stays keeps its bits.
TEST(CurveMap, IsRigidBeyondItsEnds) {
  Random random(5);
  for (int i = 0; i < 10; ++i) {
    Segment segment = random_curve(random, 1, true);
    segment.curve.anchor = 0;
    segment.curve.shift = segment.curve.turn = {0, 0, 0};
    const CurveTable<double> table(segment.curve, 0.0);
    std::vector<Vec3d> first(20);
    std::vector<Vec3d> last(20);
    segment.curve.place = {0, 0, 0};
    for (Vec3d& x : first) table.place({random.uniform(-1, 0), {random.uniform(-2, 2), random.uniform(-2, 2)}}, x);
    for (Vec3d& x : last) table.place({random.uniform(1, 2), {random.uniform(-2, 2), random.uniform(-2, 2)}}, x);
    EXPECT_EQ(moved({{segment}}, first, 1), first);
    const std::vector<Vec3d> there = moved({{segment}}, last, 1);
    for (std::size_t k = 1; k < last.size(); ++k) {
      EXPECT_NEAR(norm(there[k] - there[0]), norm(last[k] - last[0]), 1e-12);
    }
    const Flow flow{{segment}};
    const FlowSupport support(flow);
    EXPECT_FALSE(support.may_move(first[0] - segment.curve.frame.row0 * 2, 1));
    EXPECT_TRUE(support.may_move(last[0], 0.1));
  }
}

// A motion of space moves the map along: nothing depends on where a curve lies.
TEST(CurveMap, DoesNotDependOnWhereTheCurveLies) {
  Random random(6);
  const Segment segment = random_curve(random, 1, false);
  const RigidMotion motion = rotation_about(random.in_box(5), random.in_box(1), 2);
  Segment other = segment;
  other.curve.place = motion(segment.curve.place);
  other.curve.shift = motion.turn * segment.curve.shift;
  other.curve.turn = motion.turn * segment.curve.turn;
  const Mat3d& frame = segment.curve.frame;
  other.curve.frame = {motion.turn * frame.row0, motion.turn * frame.row1, motion.turn * frame.row2};
  const std::vector<Vec3d> places = places_about(segment, random, 500);
  std::vector<Vec3d> turned = places;
  for (Vec3d& x : turned) x = motion(x);
  const std::vector<Vec3d> there = moved({{segment}}, places, 1);
  const std::vector<Vec3d> of_other = moved({{other}}, turned, 1);
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_LE(norm(motion(there[i]) - of_other[i]), 1e-12);
}

TEST(CurveMap, GivesTheSameBitsForAnyThreadsAndOrder) {
  Random random(7);
  const Segment segment = random_curve(random, 1, false);
  std::vector<Vec3d> places = places_about(segment, random, 10'000);
  AdvectOptions options = options_of(1);
  options.threads = 1;
  std::vector<Vec3d> one = places;
  advect({{segment}}, one, options);
  std::reverse(places.begin(), places.end());
  options.threads = 4;
  options.precision = Precision::float64;
  advect({{segment}}, places, options);
  std::reverse(places.begin(), places.end());
  EXPECT_EQ(one, places);
}

TEST(CurveMap, MovesOnlyWhatIsWithinItsRadius) {
  Random random(8);
  Segment segment = random_curve(random, 1, true);
  const std::vector<Vec3d> places = places_about(segment, random, 1000);
  const std::vector<Vec3d> all = moved({{segment}}, places, 1);
  segment.curve.radius = 0.03;
  const std::vector<Vec3d> some = moved({{segment}}, places, 1);
  const CurveTable<double> table(segment.curve, 0.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec3d d = places[i] - segment.curve.place - table.end(false).place;
    EXPECT_EQ(some[i], norm(cross(table.end(false).frame[0], d)) <= 0.03 ? all[i] : places[i]);
  }
}

// Distances across the curve stay; det J = 1 - k.y is what lengths along it become.
TEST(CurveMap, KeepsTheThicknessIfAsked) {
  Random random(9);
  Segment segment = random_curve(random, 1, true);
  segment.curve.keeps_thickness = true;
  std::vector<CurveNode> nodes(segment.curve.nodes.begin(), segment.curve.nodes.end());
  for (CurveNode& node : nodes) node.stretch = 0;
  segment.curve.nodes = SharedList<CurveNode>(std::move(nodes));
  EXPECT_TRUE(changes_volume(segment));
  const std::vector<Vec3d> places = places_about(segment, random, 1000);
  const std::vector<Vec3d> there = moved({{segment}}, places, 1);
  const std::vector<Mat3d> all = jacobians({{segment}}, places, options_of(1));
  const CurveTable<double> begin(segment.curve, 0.0);
  const CurveTable<double> end(segment.curve, 1.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto before = begin.find(places[i] - segment.curve.place);
    const auto after = end.find(there[i] - segment.curve.place);
    ASSERT_TRUE(before && after);
    EXPECT_NEAR(std::hypot(before->across[0], before->across[1]), std::hypot(after->across[0], after->across[1]), 1e-9);
    Vec3d on_line;
    ASSERT_TRUE(end.place(CurvePoint<double>{after->s, {0, 0}}, on_line));
    EXPECT_NEAR(norm(there[i] - segment.curve.place - on_line), std::hypot(after->across[0], after->across[1]), 1e-9);
    EXPECT_GT(determinant(all[i]), 0.5);
  }
}

// Where nothing can follow the curve, and under a mask, the points stay.
TEST(CurveMap, RefusesWhatCannotFollow) {
  Segment segment;
  segment.curve.length = 10;
  segment.curve.nodes = SharedList<CurveNode>(std::vector<CurveNode>(29, {{}, {0, 0.5}}));
  std::vector<Vec3d> points{{5, 0, 0.9}, {5, 0, 1.1}};
  const std::vector<Vec3d> before = points;
  EXPECT_EQ(advect({{segment}}, points, options_of(1)).status, AdvectStatus::step_limit);
  EXPECT_EQ(points, before);
  points.pop_back();
  EXPECT_EQ(advect({{segment}}, points, options_of(1)).status, AdvectStatus::done);
  segment.mask = Mask(std::vector<Vec3d>{{5, 0, 0}}, {}, 1);
  EXPECT_THROW(advect({{segment}}, points, options_of(1)), InvalidInput);
  segment.mask = Mask(std::vector<Vec3d>{{-8, 0, 0}}, {}, 1);  // what rests may be masked
  points = {{5, 0, 0.9}};
  EXPECT_EQ(advect({{segment}}, points, options_of(1)).status, AdvectStatus::done);
}

}  // namespace knead::curve_map_test
