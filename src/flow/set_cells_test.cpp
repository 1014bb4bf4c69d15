// Trees of points, and the cells of point sets' fields.
#include "flow/sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "support/dual.h"
#include "support/random_segments.h"

namespace knead::set_cells_test {
namespace {

using detail::ListDemand;
using detail::PointTree;
using detail::SetCell;
using detail::SetCells;
using detail::WeightedPoint;
using test::Dual;
using test::moved;
using test::precisely;
using test::Random;

PointSet<double> random_set(Random& random, int count, int exponent) {
  PointSet<double> set;
  set.exponent = exponent;
  for (int i = 0; i < count; ++i) {  // on a bent sheet
    const double x = random.uniform(-0.5, 0.5);
    const double y = random.uniform(-0.5, 0.5);
    set.points.push_back({x, y, 0.3 * x * y});
  }
  return set;
}

PackedSet<double> packed_list(const std::vector<WeightedPoint>& list, int exponent) {
  PointPacks<double> points;
  for (const WeightedPoint& p : list) points.push_back(p.p, p.weight);
  return {std::make_shared<const PointPacks<double>>(std::move(points)), std::make_shared<const Curves<double>>(),
          exponent};
}

// The bound is strict: of r^-m by the demanded error, so of r by 1/m of it, everywhere in the ball.
TEST(PointTree, ListsKeepTheirErrorEverywhereInTheBall) {
  Random random(101);
  std::size_t listed = 0;
  std::size_t all = 0;
  for (int i = 0; i < 300; ++i) {
    const PointSet<double> set = random_set(random, 2000, std::array{2, 4, 8, 10, 16}[static_cast<std::size_t>(i % 5)]);
    const PackedSet<double> whole = packed<double>(set);
    const PointTree tree(set.points);
    const double radius = random.uniform(0.005, 0.1);
    const Vec3d center = random.in_box(0.8);
    const double nearest = std::sqrt(least_squared_distance(whole, center));
    const RegionValue<double> r = evaluate(whole, center, 0.0);
    const double error = std::pow(10.0, random.uniform(-6, -1));
    std::vector<WeightedPoint> list;
    tree.list(
        {center, radius, r.value, r.gradient, nearest, r.value * (1 + radius / nearest), true, set.exponent, error},
        list);
    const PackedSet<double> part = packed_list(list, set.exponent);
    listed += list.size();
    all += set.points.size();
    for (int k = 0; k < 10; ++k) {
      const Vec3d x = center + random.unit() * (radius * random.uniform(0, 1));
      const RegionValue<double> exact = evaluate(whole, x, 0.0);
      const RegionValue<double> found = evaluate(part, x, 0.0);
      // (1 + error)^(1/m) - 1, or (1 - error)^(-1/m) - 1, which is the greater.
      EXPECT_LE(std::abs(found.value / exact.value - 1), std::pow(1 - error, -1.0 / set.exponent) - 1 + 1e-13);
      // The gradient's own terms have one power more: d^-(m+1) against r^-(m+1), so at most (m + 2)/m of the error,
      // times the rise of d over r, which the margins of the bound cover.
      EXPECT_LE(norm(found.gradient - exact.gradient), 3 * error + 1e-12);
    }
  }
  EXPECT_LT(listed, all / 4 * 3);
}

Segment segment_of(const PointSet<double>& set, const Vec3d& by) {
  return test::translating(set, {0.2, -0.1, 0.3}, by, {0, 0.4});
}

// Of the field as it is evaluated: lists of few points, with dual numbers.
TEST(SetCells, FieldsAreDivergenceFreeAndTheirGradientsExact) {
  Random random(102);
  int listed = 0;
  for (int i = 0; i < 20; ++i) {
    const PointSet<double> set = random_set(random, 500, i % 2 == 0 ? 8 : 16);
    const Segment segment = segment_of(set, random.unit() * 0.01);
    const SetCells<double> cells(segment, 1e-4);
    for (int k = 0; k < 50; ++k) {
      const Vec3d x = segment.fields[0].center + random.in_box(0.8);
      SetCells<double>::Place place{};
      cells.keeps(place, x, 0);
      if (place == nullptr || place->fields.empty()) continue;
      const auto& field = place->fields.front();
      if (field.region.points->count < set.points.size()) ++listed;
      const Vec3<Dual> d = test::variables(x - field.center);
      const RegionValue<Dual> r = evaluate(field.region, d, Dual(0));
      EXPECT_LT(norm(r.value.g - test::values(r.gradient)), 1e-10);
      const Vec3<Dual> v = velocity(field.motion, field.region, field.thresholds, d, Dual(0));
      EXPECT_LT(std::abs(test::divergence(v)), 1e-10 * (1 + test::jacobian_size(v)));
    }
  }
  EXPECT_GT(listed, 200);
}

// Against the same field by brute force, which the second field makes it: lists alone use up half the tolerance, and
// the integration its own part.
// Half as much again as the tolerance, as in Advect.ErrorStaysWithinTheTolerance: what is left of the flow magnifies an
// error made on the way.
TEST(SetCells, MoveAsBruteForceDoes) {
  Random random(103);
  for (const double length : {0.002, 0.05, 0.6}) {
    for (const int exponent : {8, 16}) {
      const PointSet<double> set = random_set(random, 300, exponent);
      Segment segment = segment_of(set, random.unit() * length);
      const auto points = test::random_points(random, 300, 1.0);
      for (const int falloff : {4, 3, 7}) {
        segment.fields.front().thresholds.falloff = falloff;
        const auto exact = moved(Flow{{test::without_closed_form(segment)}}, points, precisely(1e-9));
        for (const double tolerance : {1e-4, 1e-6}) {
          EXPECT_LT(test::greatest_distance(moved(Flow{{segment}}, points, precisely(tolerance)), exact),
                    1.5 * tolerance)
              << falloff;
          AdvectOptions options = precisely(tolerance);
          options.precision = Precision::float32;
          EXPECT_LT(test::greatest_distance(moved(Flow{{segment}}, points, options), exact), 1.5 * tolerance + 3e-6)
              << falloff;
        }
      }
    }
  }
}

TEST(SetCells, ForwardsThenBackwardsReturns) {
  Random random(104);
  for (const double length : {0.002, 0.3}) {
    const PointSet<double> set = random_set(random, 500, 8);
    const Segment segment = segment_of(set, random.unit() * length);
    const auto points = test::random_points(random, 1000, 1.0);
    for (const double tolerance : {1e-4, 1e-5}) {
      const auto there = moved(Flow{{segment}}, points, precisely(tolerance));
      const auto back = moved(inverse(Flow{{segment}}), there, precisely(tolerance));
      EXPECT_LT(test::greatest_distance(back, points), 2 * tolerance);
    }
  }
}

std::vector<std::uint64_t> bits(const std::vector<Vec3d>& points) {
  std::vector<std::uint64_t> result;
  for (const Vec3d& p : points) {
    for (const double x : {p.x, p.y, p.z}) result.push_back(std::bit_cast<std::uint64_t>(x));
  }
  return result;
}

// Short segments evaluate several path lines at a time, and the first thread that needs a cell makes it.
TEST(SetCells, DoNotDependOnThreadsNorOnTheOtherPoints) {
  Random random(105);
  Flow flow;
  for (const double length : {0.001, 0.4}) {
    const PointSet<double> set = random_set(random, 300, 16);
    flow.segments.push_back(segment_of(set, random.unit() * length));
  }
  flow.segments.push_back(flow.segments.front());  // two parts
  flow.segments.back().fields.push_back(flow.segments[1].fields.front());
  flow.segments.back().fields.back().motion = flow.segments.front().fields.front().motion;
  const auto points = test::random_points(random, 5000, 0.9);
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(105));
  std::vector<Vec3d> shuffled;
  for (const std::size_t i : order) shuffled.push_back(points[i]);
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    AdvectOptions options = precisely(1e-5);
    options.precision = precision;
    options.threads = 1;
    const auto one = moved(flow, points, options);
    EXPECT_NE(bits(one), bits(points));
    options.threads = 2;
    EXPECT_EQ(bits(moved(flow, points, options)), bits(one));
    const auto permuted = moved(flow, shuffled, options);
    for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(bits({permuted[i]}), bits({one[order[i]]}));
    for (std::size_t i = 0; i < 100; ++i) ASSERT_EQ(bits(moved(flow, {points[i]}, options)), bits({one[i]}));
  }
}

TEST(SetCells, WhatTheSetDoesNotReachKeepsItsBits) {
  Random random(106);
  const Segment segment = segment_of(random_set(random, 300, 16), {0.001, 0.002, -0.001});
  const auto points = test::random_points(random, 3000, 2.0);
  const auto after = moved(Flow{{segment}}, points, precisely(1e-5));
  int outside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (region_value(segment.fields[0], points[i] - segment.fields[0].center).value < 0.41) continue;
    ++outside;
    EXPECT_EQ(bits({after[i]}), bits({points[i]}));
  }
  EXPECT_GT(outside, 1000);
}

// Far parts cost nothing, near ones add up as the sum of the fields.
TEST(SetCells, PartsAddUp) {
  Random random(107);
  Segment several = segment_of(random_set(random, 60, 8), {0.03, 0.02, -0.04});
  for (int i = 1; i < 12; ++i) {
    Field part = several.fields.front();
    part.region = random_set(random, 20, 8);
    part.center += Vec3d{0.9 * i, 0.1 * i, 0};
    several.fields.push_back(part);
  }
  std::vector<Vec3d> points;
  for (int i = 0; i < 1000; ++i) {
    points.push_back({random.uniform(-1, 11), random.uniform(-1, 2), random.uniform(-0.5, 0.8)});
  }
  const auto exact = moved(Flow{{test::without_closed_form(several)}}, points, precisely(1e-9));
  EXPECT_GT(test::greatest_distance(exact, points), 0.03);
  EXPECT_LT(test::greatest_distance(moved(Flow{{several}}, points, precisely(1e-6)), exact), 1e-6);
}

// Near to the set, far from it, on its points, and so near to one that sums by another overflow: the tree goes down to
// the wrong side of two clusters.
TEST(GuidedSet, IsTheSetItself) {
  Random random(107);
  for (const int exponent : {8, 16}) {
    PointSet<double> set = random_set(random, 1500, exponent);
    for (int i = 0; i < 200; ++i) set.points.push_back(Vec3d{3, 0, 0} + random.in_box(0.01));
    set.points.push_back({1.2, 0, 0});
    const PackedSet<float> whole = packed<float>(set);
    const detail::GuidedSet<float> guided = detail::guided<float>(set);
    std::vector<Vec3d> places = test::random_points(random, 2000, 4);
    for (const Vec3d& p : set.points) {
      for (const double away : {0.0, 1e-7, 1e-5, 1e-2}) places.push_back(p + random.unit() * away);
    }
    for (const Vec3d& place : places) {
      const Vec3<float> d(place);
      const RegionValue<float> expected = evaluate(whole, d, 0.0F);
      const RegionValue<float> r = evaluate(guided, d, 0.0F);
      // Sums of floats by another unit: each term is rounded some ten times.
      EXPECT_NEAR(r.value, expected.value, 2e-6 * expected.value);
      EXPECT_LT(norm(r.gradient - expected.gradient), 1e-5);
    }
  }
}

}  // namespace
}  // namespace knead::set_cells_test
