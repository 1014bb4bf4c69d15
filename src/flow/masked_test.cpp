// Segments under masks.
#include "flow/masked.h"

#include <gtest/gtest.h>

#include <cmath>

#include "flow/path_jacobian.h"
#include "knead/mesh.h"
#include "support/outcome.h"
#include "support/random_segments.h"

namespace knead::masked_test {
namespace {

using test::moved;
using test::NamedSegment;
using test::Outcome;
using test::outcome_of;
using test::precisely;
using test::Random;

// Half of the points about the origin: those with x < 0.
Mask mask_of_half(const std::vector<Vec3d>& points, double width = 0.3) {
  std::vector<Vec3d> masked;
  for (const Vec3d& p : points) {
    if (p.x < 0) masked.push_back(p);
  }
  return Mask(masked, {}, width);
}

// A mask for each, which acts.
std::vector<NamedSegment> masked_segments(Random& random, const Mask& mask, int falloff = kDefaultFalloff) {
  std::vector<NamedSegment> result;
  for (NamedSegment named : test::random_segments(random, falloff)) {
    named.segment.mask = mask;
    if (detail::mask_on(named.segment).acts) result.push_back(named);
  }
  return result;
}

Mesh unit_sphere() { return make_shape(ShapeKind::sphere, 10242); }

TEST(Masked, PointsKeepTheirBitsForEverySegment) {
  Random random(501);
  std::vector<Vec3d> points = test::random_points(random, 4000);
  points.push_back({-0.3, -0.0, 0.0});
  const Mask mask = mask_of_half(points);
  int kinds = 0;
  for (const NamedSegment& named : masked_segments(random, mask)) {
    ++kinds;
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      AdvectOptions options = precisely(1e-6);
      options.precision = precision;
      for (const Flow& flow : {Flow{{named.segment}}, inverse(Flow{{named.segment}})}) {
        const auto after = moved(flow, points, options);
        const auto bits = test::bits(after);
        const auto before = test::bits(points);
        int free = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
          if (points[i].x < 0) {
            EXPECT_TRUE(std::equal(&bits[3 * i], &bits[3 * i] + 3, &before[3 * i])) << named.name;
          } else {
            free += after[i] == points[i] ? 0 : 1;
          }
        }
        EXPECT_GT(free, 20) << named.name;
      }
    }
  }
  EXPECT_GT(kinds, 14);
}

TEST(Masked, ForwardsThenBackwardsReturns) {
  Random random(502);
  const std::vector<Vec3d> points = test::random_points(random, 500);
  const Mask mask = mask_of_half(points);
  for (const NamedSegment& named : masked_segments(random, mask)) {
    const Flow flow{{named.segment}};
    const auto there = moved(flow, points, precisely(1e-10));
    EXPECT_LT(test::greatest_distance(moved(inverse(flow), there, precisely(1e-10)), points), 1e-6) << named.name;
  }
}

// A segment in one, and the same in pieces: the constant of the potential is that of the whole segment.
TEST(Masked, PiecesMakeTheWhole) {
  Random random(503);
  const std::vector<Vec3d> points = test::random_points(random, 500);
  const Mask mask = mask_of_half(points);
  for (const NamedSegment& named : masked_segments(random, mask)) {
    const Flow whole{{named.segment}};
    Flow pieces;
    for (int i = 0; i < 4; ++i) {
      pieces.segments.push_back(named.segment);
      pieces.segments.back().begin = 0.25 * i;
      pieces.segments.back().end = 0.25 * (i + 1);
    }
    const auto exact = moved(whole, points, precisely(1e-11));
    EXPECT_LT(test::greatest_distance(moved(pieces, points, precisely(1e-11)), exact), 1e-7) << named.name;
    // One of the balls' 500 points runs along the mask's border, where the flow magnifies errors: 1.7e-4.
    EXPECT_LT(test::greatest_distance(moved(whole, points, test::in_float()), exact), 2e-4) << named.name;
  }
}

// Which threads, registers and neighbours a point has does not matter.
TEST(Masked, BitsDependOnThePointAlone) {
  Random random(504);
  const std::vector<Vec3d> points = test::random_points(random, 331);
  const Mask mask = mask_of_half(points);
  for (const NamedSegment& named : masked_segments(random, mask)) {
    const Flow flow{{named.segment}};
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      AdvectOptions options = precisely(1e-5);
      options.precision = precision;
      options.threads = 1;
      const Outcome one = outcome_of(flow, points, options);
      options.threads = 2;
      for (const std::string& name : test::simd_names()) {
        const test::Simd simd(name);
        EXPECT_EQ(outcome_of(flow, points, options), one) << named.name << ", " << name;
      }
      const auto together = moved(flow, points, options);
      for (std::size_t i = 0; i < points.size(); i += 17) {
        EXPECT_EQ(moved(flow, {points[i]}, options)[0], together[i]) << named.name;
      }
    }
  }
}

TEST(Masked, HoldsForEveryFalloff) {
  for (const int falloff : test::kOtherFalloffs) {
    Random random(510);
    const std::vector<Vec3d> points = test::random_points(random, 500);
    const Mask mask = mask_of_half(points);
    for (const NamedSegment& named : masked_segments(random, mask, falloff)) {
      const Flow flow{{named.segment}};
      const auto there = moved(flow, points, precisely(1e-10));
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].x < 0) {
          EXPECT_EQ(there[i], points[i]) << named.name << ", falloff " << falloff;
        }
      }
      EXPECT_LT(test::greatest_distance(moved(inverse(flow), there, precisely(1e-10)), points), 1e-6)
          << named.name << ", falloff " << falloff;
      const Outcome one = outcome_of(flow, points, test::in_float());
      for (const std::string& name : test::simd_names()) {
        const test::Simd simd(name);
        EXPECT_EQ(outcome_of(flow, points, test::in_float()), one) << named.name << ", " << name;
      }
    }
  }
}

TEST(Masked, SegmentsThatDoNotReachTheMaskHaveTheirBits) {
  Random random(505);
  const std::vector<Vec3d> points = test::random_points(random, 400);
  const Mask far(std::vector<Vec3d>{{9, 9, 9}}, {}, 0.3);
  int same = 0;
  for (const NamedSegment& named : test::random_segments(random)) {
    Segment with = named.segment;
    with.mask = far;
    if (detail::mask_on(with).acts) continue;
    ++same;
    EXPECT_EQ(outcome_of(Flow{{with}}, points, test::in_float()),
              outcome_of(Flow{{named.segment}}, points, test::in_float()))
        << named.name;
  }
  EXPECT_GT(same, 8);
}

// Volume, by the Jacobian of the computed map, is kept as without a mask; and the path line is that of advect.
TEST(Masked, VolumeIsKept) {
  Random random(506);
  const std::vector<Vec3d> points = test::random_points(random, 300);
  const Mask mask = mask_of_half(points);
  AdvectOptions options = precisely(1e-9);
  int counted = 0;
  for (const NamedSegment& named : masked_segments(random, mask)) {
    if (named.name.find("capsule") != std::string::npos) continue;  // its v is only C0 on the planes through its ends
    for (std::size_t i = 0; i < points.size(); i += 60) {
      const Vec3d point = points[i] + Vec3d{0.3, 0, 0};
      Vec3d x = point;
      const double drift = volume_drifts(Flow{{named.segment}}, {&x, 1}, options).front();
      EXPECT_LT(norm(x - moved(Flow{{named.segment}}, {point}, options)[0]), 1e-6) << named.name;
      if (std::isnan(drift)) continue;
      ++counted;
      EXPECT_LT(std::abs(drift), 1e-4) << named.name;
    }
  }
  EXPECT_GT(counted, 40);
}

TEST(Masked, AClosedShapeKeepsItsVolume) {
  const Mesh sphere = unit_sphere();
  std::vector<Vec3d> masked_points;
  for (const Vec3d& p : sphere.positions) {
    if (p.x < 0) masked_points.push_back(p);
  }
  Flow flow{{test::translating(Ball<double>{}, {0.2, 0.8, 0}, {0, 0.5, 0}, {0.2, 0.8})}};
  flow = masked(flow, Mask(masked_points, {}, 0.3));
  const auto after = moved(flow, sphere.positions, test::in_float());
  EXPECT_NEAR(measure_volume_and_area(sphere, after).volume / measure(sphere).volume, 1, 1e-3);  // of sampling
  EXPECT_EQ(after[static_cast<std::size_t>(std::min_element(sphere.positions.begin(), sphere.positions.end(),
                                                            [](const Vec3d& a, const Vec3d& b) { return a.x < b.x; }) -
                                           sphere.positions.begin())],
            *std::min_element(sphere.positions.begin(), sphere.positions.end(),
                              [](const Vec3d& a, const Vec3d& b) { return a.x < b.x; }));
}

// A ball pulled along a plane border at a distance from its centre: the constant of the potential keeps the flow along
// the border near the tool's speed (method, section 10). Without it the figures are 1.0 to 4.0.
TEST(Masked, TheFlowAlongABorderIsSlow) {
  std::vector<Vec3d> wall;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      for (int k = 0; k < 12; ++k) wall.push_back({-0.04 * k, 0.04 * i, 0.04 * j});
    }
  }
  Random random(507);
  const std::vector<Vec3d> places = test::random_points(random, 6000, 1.3);
  const Vec3d by{0, 0.3, 0};
  for (const auto& [width, distance] :
       {std::pair{0.1, 0.3}, {0.1, 0.6}, {0.2, 0.1}, {0.2, 0.3}, {0.2, 0.6}, {0.4, 0.3}}) {
    Segment segment = test::translating(Ball<double>{}, {0.65 * width + distance, 0, 0}, by, {0.2, 1});
    segment.mask = Mask(wall, {}, width);
    const detail::BorderSpeed speed = detail::border_speed(segment, places);
    EXPECT_LT(speed.at_border, 1.25 * norm(by)) << width << " " << distance;
    EXPECT_NEAR(speed.of_tool, norm(by), 0.2 * norm(by));
  }
}

}  // namespace
}  // namespace knead::masked_test
