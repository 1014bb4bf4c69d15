// The tool "handles": exact motion of the moving set, exact rest of the fixed set, and a smooth field between them.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "support/dual.h"
#include "support/random_segments.h"

namespace knead::handles_test {
namespace {

using test::in_float;
using test::moved;
using test::precisely;
using test::Random;

// A bar along x, of which the caps are marked: the right one moves, the left one rests.
struct MarkedBar {
  Mesh mesh = make_shape(ShapeKind::box, 600);
  HandlesStroke stroke;

  explicit MarkedBar(const std::variant<HandlesTranslation, HandlesRotation>& motion, double from = 2) {
    stroke.motion = motion;
    for (const Vec3d& p : mesh.positions) {
      if (p.x > from) stroke.full.push_back(p);
      if (p.x < -from) stroke.zero.push_back(p);
    }
  }
};

bool contains(const std::vector<Vec3d>& points, const Vec3d& x) {
  return std::find(points.begin(), points.end(), x) != points.end();
}

HandlesRotation half_twist(double degrees) { return {{1, 0.2, 0}, {0, 0.1, 0}, degrees}; }

TEST(Handles, PointsOfATranslatedFullSetMoveToTheBitAndThoseOfTheZeroSetKeepTheirs) {
  const Vec3d by{0.3, 1.1, -0.7};
  const MarkedBar bar(HandlesTranslation{by});
  for (const AdvectOptions& options : {in_float(), precisely(1e-7)}) {
    const auto after = moved(flow_of(bar.stroke), bar.mesh.positions, options);
    int full = 0;
    int zero = 0;
    int between = 0;
    for (std::size_t i = 0; i < after.size(); ++i) {
      const Vec3d& x = bar.mesh.positions[i];
      if (contains(bar.stroke.full, x)) {
        ++full;
        EXPECT_EQ(after[i], x + by);
      } else if (contains(bar.stroke.zero, x)) {
        ++zero;
        EXPECT_EQ(after[i], x);
      } else {
        ++between;
        EXPECT_NE(after[i], x);
      }
    }
    EXPECT_GT(std::min({full, zero, between}), 100);
  }
}

TEST(Handles, AZeroPointKeepsItsNegativeZeros) {
  HandlesStroke stroke;
  stroke.full = {{1, 0, 0}};
  stroke.zero = {{-0.0, 0.0, -0.0}};
  stroke.motion = HandlesTranslation{{0, 1, 0}};
  const auto after = moved(flow_of(stroke), stroke.zero, in_float());
  EXPECT_EQ(std::bit_cast<std::uint64_t>(after[0].x), std::bit_cast<std::uint64_t>(-0.0));
  EXPECT_EQ(std::bit_cast<std::uint64_t>(after[0].z), std::bit_cast<std::uint64_t>(-0.0));
}

TEST(Handles, PointsOfATurnedFullSetEndOnTheTurnForAnyAngle) {
  for (const double degrees : {30.0, -90.0, 360.0, 1000.0}) {
    const HandlesRotation turn = half_twist(degrees);
    const MarkedBar bar(turn);
    const auto full = moved(flow_of(bar.stroke), bar.stroke.full, in_float());
    const SinCos<double> sc{std::sin(degrees * std::numbers::pi / 180), std::cos(degrees * std::numbers::pi / 180)};
    for (std::size_t i = 0; i < full.size(); ++i) {
      const Vec3d expected = turn.center + rotate(bar.stroke.full[i] - turn.center, normalized(turn.axis), sc);
      EXPECT_LT(norm(full[i] - expected), 1e-13)
          << degrees;  // some roundings of numbers of size 3, and of 1000 degrees
    }
    EXPECT_EQ(moved(flow_of(bar.stroke), bar.stroke.zero, in_float()), bar.stroke.zero);
  }
}

// What rounding leaves of a divergence is relative to the Jacobian.
TEST(Handles, TheFieldIsDivergenceFreeBetweenTheSets) {
  Random random(131);
  for (const MarkedBar& bar : {MarkedBar(HandlesTranslation{{0.3, 1, 0}}), MarkedBar(half_twist(200))}) {
    const Segment segment = flow_of(bar.stroke).segments.at(0);
    const Field& field = segment.fields.at(0);
    const auto& region = std::get<Handles<double>>(field.region);
    for (int i = 0; i < 20; ++i) {
      const Vec3d d = Vec3d{random.uniform(-4, 4), random.uniform(-1, 1), random.uniform(-1, 1)};
      const test::Dual t(random.uniform(0, 1));
      std::visit(
          [&](const auto& motion) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(motion)>, CustomMotion>) {
              const auto v = velocity(motion, region, field.thresholds, test::variables(d), t);
              EXPECT_LT(std::abs(test::divergence(v)), 1e-12 * std::fmax(1, test::jacobian_size(v)));
            }
          },
          field.motion);
    }
  }
}

// Across a point of either set: there the distances have kinks, and v must not.
TEST(Handles, TheFieldIsC1AtThePointsOfBothSets) {
  const MarkedBar bar(HandlesTranslation{{0.3, 1, 0}});
  const Field field = flow_of(bar.stroke).segments.at(0).fields.at(0);
  const auto& region = std::get<Handles<double>>(field.region);
  const auto& motion = std::get<Translation<double>>(field.motion);
  Random random(132);
  for (const PointSet<double>* set : {&region.full, &region.zero}) {
    for (std::size_t i = 0; i < set->points.size(); i += set->points.size() / 10) {
      const Vec3d step = random.unit() * 1e-5;
      const auto jacobian = [&](double s) {
        return velocity(motion, region, field.thresholds, test::variables(set->points[i] + step * s), test::Dual(0.0));
      };
      // Second derivatives of up to 6 s (24 R / gap^3) times the step.
      EXPECT_LT(test::jacobian_difference(jacobian(-1), jacobian(1)), 2e-3);
    }
  }
}

TEST(Handles, ForwardsThenBackwardsReturns) {
  for (const MarkedBar& bar : {MarkedBar(HandlesTranslation{{0.3, 1.5, 0}}), MarkedBar(half_twist(120))}) {
    const Flow flow = flow_of(bar.stroke);
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < bar.mesh.positions.size(); i += 7) points.push_back(bar.mesh.positions[i]);
    const auto there = moved(flow, points, precisely(1e-9));
    EXPECT_LT(test::greatest_distance(moved(inverse(flow), there, precisely(1e-9)), points), 1e-7);
    const auto coarse = moved(flow, points, in_float());
    EXPECT_LT(test::greatest_distance(coarse, there), 1e-4);  // ten tolerances, for what the flow stretches
    EXPECT_LT(test::greatest_distance(moved(inverse(flow), coarse, in_float()), points), 1e-4);
  }
}

// The field at a moment depends only on where the full set then is, so the motion may be cut as one likes.
TEST(Handles, OneStrokeIsTenOfATenthOfTheMotion) {
  const Vec3d by{0.5, 2, 0};
  MarkedBar bar(HandlesTranslation{by});
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < bar.mesh.positions.size(); i += 11) points.push_back(bar.mesh.positions[i]);
  const auto once = moved(flow_of(bar.stroke), points, precisely(1e-9));
  auto often = points;
  bar.stroke.motion = HandlesTranslation{by * 0.1};
  for (int i = 0; i < 10; ++i) {
    often = moved(flow_of(bar.stroke), often, precisely(1e-9));
    for (Vec3d& p : bar.stroke.full) p += by * 0.1;
  }
  EXPECT_LT(test::greatest_distance(once, often), 1e-7);
}

// A point beside the full set, where w rounds to 1 in float, is left behind where the set passes close to a zero point.
TEST(Handles, APointBesideTheFullSetIsShedWhereItPassesCloseToAZeroPoint) {
  HandlesStroke stroke;
  stroke.full = {{1, 0, 0}};
  stroke.zero = {{0, 1e-3, 0}};
  stroke.motion = HandlesTranslation{{-2, 0, 0}};
  const std::vector<Vec3d> points{{1, 1e-5, 0}, {1, 1e-4, 0}, {1, -1e-3, 3e-4}, {1, 1e-3, 3e-4}};
  AdvectOptions options = in_float();
  options.tolerance = 1e-6;
  const auto coarse = moved(flow_of(stroke), points, options);
  const auto exact = moved(flow_of(stroke), points, precisely(1e-10));
  EXPECT_LT(test::greatest_distance(coarse, exact), 5e-6);  // measured 4e-7; float's rounding along a way of 2
  EXPECT_LT(norm(exact[3]), 0.01);
}

// There r is 1/2, w = 0.6875^2, and A's growth with the distance does not make up for the fall of grad r.
TEST(Handles, MoveWhatIsFarAwayByTheWeightOfOneHalf) {
  HandlesStroke stroke;
  stroke.full = {{1, 0, 0}, {1, 1, 0}};
  stroke.zero = {{-1, 0, 0}, {-1, 1, 0}};
  const Vec3d by{0, 1, 0.5};
  stroke.motion = HandlesTranslation{by};
  for (const Vec3d& far : {Vec3d{0, 1000, 0}, Vec3d{0, -300, 1000}, Vec3d{2000, 0, 0}}) {
    const Vec3d after = moved(flow_of(stroke), {far}, in_float()).front();
    EXPECT_LT(norm(after - far - by * (0.6875 * 0.6875)),
              0.01);  // a few times the sets' distance over that of the point
  }
}

TEST(Handles, KeepVolume) {
  for (const MarkedBar& bar : {MarkedBar(HandlesTranslation{{0.5, 0.5, 0}}), MarkedBar(half_twist(90))}) {
    const auto after = moved(flow_of(bar.stroke), bar.mesh.positions, in_float());
    const double before_volume = measure(bar.mesh).volume;
    const double volume = measure_volume_and_area(bar.mesh, after).volume;
    EXPECT_NEAR(volume / before_volume, 1, 5e-3);  // sampling: 600 vertices
  }
}

// Turning many times winds path lines up, and sweeping the full set over a zero point asks for the impossible; neither
// may run for ever.
TEST(Handles, LargeMotionsComeToAnEnd) {
  std::vector<Vec3d> points;
  MarkedBar bar(half_twist(1440));
  for (std::size_t i = 0; i < bar.mesh.positions.size(); i += 11) points.push_back(bar.mesh.positions[i]);
  EXPECT_NO_THROW(moved(flow_of(bar.stroke), points, in_float()));
  for (const Vec3d& by : {Vec3d{50, 3, 0}, Vec3d{-5, 0, 0}}) {
    bar.stroke.motion = HandlesTranslation{by};
    EXPECT_NO_THROW(moved(flow_of(bar.stroke), points, in_float()));
  }
}

TEST(Handles, AreAValidFlowOfOneSweptSegment) {
  const MarkedBar bar(HandlesTranslation{{0, 1, 0}});
  const Flow flow = flow_of(bar.stroke);
  EXPECT_NO_THROW(validate(flow));
  ASSERT_EQ(flow.segments.size(), 1u);
  EXPECT_EQ(flow.segments[0].displacement, Vec3d(0, 1, 0));
  EXPECT_EQ(flow.segments[0].fields.at(0).thresholds, (Thresholds<double>{0, 1}));
  const Flow turn = flow_of(MarkedBar(half_twist(10)).stroke);
  EXPECT_NO_THROW(validate(turn));
  EXPECT_EQ(turn.segments.at(0).fields.at(0).center, Vec3d(0, 0.1, 0));
}

TEST(Handles, AreRefusedForValuesThatMeanNothing) {
  const auto refusal = [](const auto& change) -> std::string {
    HandlesStroke stroke;
    stroke.full = {{1, 0, 0}, {1, 1, 0}};
    stroke.zero = {{-1, 0, 0}};
    stroke.motion = HandlesRotation{{0, 0, 1}, {0, 0, 0}, 40};
    change(stroke);
    try {
      validate(stroke);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  const double nan = std::nan("");
  EXPECT_EQ(refusal([](HandlesStroke&) {}), "");
  EXPECT_EQ(refusal([](HandlesStroke& s) { s.full.clear(); }), "\"full\" must hold 1 or more points, got 0");
  EXPECT_EQ(refusal([](HandlesStroke& s) { s.zero.clear(); }), "\"zero\" must hold 1 or more points, got 0");
  EXPECT_EQ(refusal([](HandlesStroke& s) {
              s.zero.clear();
              s.zero_vertices = {3, 4};
            }),
            "");
  EXPECT_TRUE(refusal([](HandlesStroke& s) { s.full_vertices = {1}; }).starts_with("\"full\" must not be given"));
  EXPECT_TRUE(refusal([](HandlesStroke& s) {
                s.full.clear();
                s.zero.clear();
                s.full_vertices = {5, 9};
                s.zero_vertices = {9, 2};
              }).starts_with("\"zero_vertices\" must have nothing in common with \"full_vertices\", but vertex 9"));
  EXPECT_TRUE(refusal([](HandlesStroke& s) {
                s.zero.push_back({1, 1, 0});
              }).starts_with("\"zero\" must have nothing in common with \"full\", but the point [1, 1, 0]"));
  EXPECT_TRUE(refusal([&](HandlesStroke& s) { s.full[0].y = nan; }).starts_with("\"full\""));
  EXPECT_TRUE(refusal([](HandlesStroke& s) { s.exponent = 3; }).starts_with("\"exponent\" must be an even number"));
  EXPECT_TRUE(refusal([](HandlesStroke& s) {
                s.motion = HandlesRotation{{0, 0, 0}, {0, 0, 0}, 40};
              }).starts_with("\"rotate\""));
  EXPECT_TRUE(refusal([&](HandlesStroke& s) {
                s.motion = HandlesRotation{{0, 0, 1}, {0, nan, 0}, 40};
              }).starts_with("\"center\""));
  EXPECT_TRUE(refusal([](HandlesStroke& s) {
                s.motion = HandlesRotation{{0, 0, 1}, {0, 0, 0}, 1e9};
              }).starts_with("\"angle_deg\""));
  EXPECT_TRUE(refusal([&](HandlesStroke& s) {
                s.motion = HandlesTranslation{{nan, 0, 0}};
              }).starts_with("\"translate\""));
}

TEST(Handles, WarnOfAPassCloseToTheZeroSetAndOfAWideSetWithANarrowGap) {
  const auto count = [](const HandlesStroke& stroke) { return warnings(stroke).size(); };
  EXPECT_EQ(count(MarkedBar(HandlesTranslation{{0.3, 1, 0}}).stroke), 0u);
  EXPECT_EQ(count(MarkedBar(HandlesTranslation{{-5, 0, 0}}).stroke), 1u);
  EXPECT_EQ(count(MarkedBar(half_twist(90)).stroke), 0u);
  EXPECT_EQ(count(MarkedBar(HandlesRotation{{0, 1, 0}, {0, 0, 0}, 180}).stroke), 1u);
  HandlesStroke wide;  // two rows, 0.1 apart
  for (int i = 0; i <= 20; ++i) {
    wide.full.push_back({0.05, 0.1 * i, 0});
    wide.zero.push_back({-0.05, 0.1 * i, 0});
  }
  wide.motion = HandlesTranslation{{0.1, 0, 0}};
  EXPECT_EQ(count(wide), 1u);
}

}  // namespace
}  // namespace knead::handles_test
