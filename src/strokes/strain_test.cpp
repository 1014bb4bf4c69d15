// Stretches by flows, against exact values, and the zones of bends and twists.
#include "knead/editor/tools.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "support/surface.h"

namespace knead::strain_test {
namespace {

using test::Surface;

constexpr double kDegree = std::numbers::pi / 180;

StrainOptions of(const Surface& surface) { return {bounding_box(surface.positions).diagonal()}; }

Surface cylinder(std::size_t vertices = 20'000) { return Surface(make_shape(ShapeKind::cylinder, vertices)); }

// Of the cylinder (radius 0.5) about its middle.
BendStroke bend(double angle_deg, double width) {
  return {{0, 0, 0}, {1, 0, 0}, {0, 0, -1}, angle_deg, BendWidth{width}};
}

double edge_stretch(const Stroke& stroke, const Surface& surface) {
  std::vector<Vec3d> after = surface.positions;
  AdvectOptions options;
  options.tolerance = 1e-5;
  EXPECT_EQ(advect(flow_of(stroke), after, options).status, AdvectStatus::done);
  double most = 0;
  for (const Triangle& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i];
      const std::uint32_t b = t[(i + 1) % 3];
      most = std::max(most, norm(after[a] - after[b]) / norm(surface.positions[a] - surface.positions[b]));
    }
  }
  return most;
}

Mat3d rotation(const Vec3d& axis, double angle) {
  const SinCos<double> by = sincos(angle);
  const Vec3d x = rotate(Vec3d{1, 0, 0}, axis, by);
  const Vec3d y = rotate(Vec3d{0, 1, 0}, axis, by);
  const Vec3d z = rotate(Vec3d{0, 0, 1}, axis, by);
  return {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
}

TEST(Stretches, AreTheSingularValuesOfTheGradient) {
  const Mat3d before = rotation(normalized(Vec3d{1, 2, -1}), 0.8);
  const Mat3d after = rotation(normalized(Vec3d{-1, 0.3, 2}), 2.1);
  const Mat3d scaled{{0.2, 0, 0}, {0, 7, 0}, {0, 0, 1 / 1.4}};
  const Stretches s = stretches_of(after * scaled * before);
  EXPECT_NEAR(s.greatest, 7, 1e-13);
  EXPECT_NEAR(s.middle, 1 / 1.4, 1e-13);
  EXPECT_NEAR(s.least, 0.2, 1e-13);
  EXPECT_EQ(stretches_of(Mat3d{}), Stretches{});
  EXPECT_EQ(stretches_of(Mat3d({0, 0, 0}, {0, 0, 0}, {0, 0, 0})).greatest, 0);
}

TEST(Stretches, OfATwistFollowFromItsShear) {
  TwistStroke stroke{{0, 0, 0}, {0, 0, 1}, 100, 1, 2};
  const double gamma = 100 * kDegree * 0.5;
  const auto s = stretches_of(flow_of(stroke), std::vector<Vec3d>{{0.5, 0, 0.2}, {0, 0, 0.1}}, {6});
  EXPECT_NEAR(s[0].greatest, gamma / 2 + std::sqrt(1 + gamma * gamma / 4), 1e-4);
  EXPECT_NEAR(s[0].middle, 1, 1e-4);
  EXPECT_NEAR(s[1].greatest, 1, 1e-4);
}

TEST(Stretches, KeepVolumeWhereTheFlowDeforms) {
  const ImplicitStroke stroke{{{0, 0, 0}, {0.3, 0.1, 0}}, 0.3, 0.8};
  std::vector<Vec3d> points;
  for (int i = 0; i < 20; ++i) points.push_back({0.05 * i, 0.2, 0.1});
  double most = 1;
  for (const Stretches& s : stretches_of(flow_of(stroke), points, {2})) {
    EXPECT_NEAR(s.greatest * s.middle * s.least, 1, 1e-4);
    most = std::max(most, s.greatest);
  }
  EXPECT_GT(most, 1.2);
}

TEST(Stretches, IgnoreTheTearAtALimitCylinder) {
  BendStroke stroke = bend(30, 1);
  stroke.radius = 0.7;
  const auto s = stretches_of(flow_of(stroke), std::vector<Vec3d>{{0.7 - 1e-5, 0, 2}}, {6});
  EXPECT_NEAR(s[0].greatest, 1, 1e-3);
}

TEST(Stretches, NeedALength) {
  EXPECT_THROW(stretches_of(flow_of(bend(30, 1)), std::vector<Vec3d>{{0, 0, 0}}, {}), InvalidInput);
}

// The table of method.md, section 10, gauge 1: at 2.4 phi rho 2.2, at 1.6 3.0, at 1.2 4.1, for the edges.
TEST(GreatestStretch, OfABendFollowsFromItsWidth) {
  const Surface surface = cylinder();
  for (const double angle_deg : {42.0, 90.0}) {
    const double unit = angle_deg * kDegree * 0.5;
    for (const auto& [ratio, stretch] : {std::pair{2.4, 2.2}, {1.6, 3.0}, {1.2, 4.1}}) {
      const Stroke stroke = bend(angle_deg, ratio * unit);
      const GreatestStretch found = greatest_stretch(flow_of(stroke), surface.positions, of(surface));
      EXPECT_NEAR(edge_stretch(stroke, surface), stretch, 0.12 * stretch) << ratio;
      EXPECT_EQ(found.samples, 512u);
      EXPECT_NEAR(found.greatest, edge_stretch(stroke, surface), 0.1 * stretch) << ratio;
    }
    EXPECT_TRUE(greatest_stretch(flow_of(bend(angle_deg, 0.9 * unit)), surface.positions, of(surface)).is_strong());
    EXPECT_FALSE(greatest_stretch(flow_of(bend(angle_deg, 2.4 * unit)), surface.positions, of(surface)).is_strong());
  }
}

// Points in a bar of thickness 1, as wide as this along the axis, or on one with an ellipse as its section.
std::vector<Vec3d> bar(double width, bool is_round = false) {
  std::vector<Vec3d> points;
  for (int i = -60; i <= 60; ++i) {
    for (const double across : {-0.5, 0.0, 0.5}) {
      for (int k = -4; k <= 4; ++k) {
        const double along = k / 8.0;
        const double y = is_round ? 2 * across * std::sqrt(0.25 - along * along) : across;
        points.push_back({width * along, y, 0.05 * i});
      }
    }
  }
  return points;
}

double greatest_of(const BendStroke& stroke, const std::vector<Vec3d>& points) {
  double most = 1;
  for (const Stretches& s : stretches_of(flow_of(stroke), points, {10})) {
    most = std::max({most, s.greatest, 1 / s.least});
  }
  return most;
}

double greatest_in_bar(double width, double gauge) {
  BendStroke stroke = bend(45, 1);
  stroke.gauge = gauge;
  return greatest_of(stroke, bar(width));
}

// As docs/session.md advises for each width along the axis.
TEST(GreatestStretch, OfABendDependsOnGaugeAndWidth) {
  EXPECT_LT(greatest_in_bar(1, 1), 0.9 * greatest_in_bar(1, 0));
  EXPECT_LT(greatest_in_bar(2, 0.5), std::min(greatest_in_bar(2, 0), greatest_in_bar(2, 1)));
  EXPECT_LT(greatest_in_bar(6, 0), greatest_in_bar(6, 0.5));
  EXPECT_GT(greatest_in_bar(8, 1), 2.5 * greatest_in_bar(8, 0));
}

TEST(GreatestStretch, HasTheSameBitsForEveryNumberOfThreads) {
  const Surface surface = cylinder();
  const Flow flow = flow_of(bend(60, 0.8));
  StrainOptions one = of(surface);
  one.threads = 1;
  StrainOptions four = of(surface);
  four.threads = 4;
  const GreatestStretch a = greatest_stretch(flow, surface.positions, one);
  const GreatestStretch b = greatest_stretch(flow, surface.positions, four);
  EXPECT_EQ(a.greatest, b.greatest);
  EXPECT_EQ(a.least, b.least);
  EXPECT_EQ(a.where, b.where);
}

TEST(GreatestStretch, LooksOnlyWhereTheFlowDeforms) {
  const Surface surface = cylinder();
  const StretchStroke away{{9, 0, 0}, {1, 0, 0}, 2, 0.1, 0.3};
  const GreatestStretch none = greatest_stretch(flow_of(away), surface.positions, of(surface));
  EXPECT_EQ(none.samples, 0u);
  EXPECT_FALSE(none.is_strong());
  const StretchStroke here{{0, 0, 3}, {1, 0, 0}, 5, 2, 2.5};
  const GreatestStretch strong = greatest_stretch(flow_of(here), surface.positions, of(surface));
  EXPECT_TRUE(strong.is_strong());
  EXPECT_GE(strong.greatest, 4.99);
}

TEST(TriangleStretch, IsTheGreatestSingularValue) {
  const std::array<Vec3d, 3> rest{Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}};
  const double gamma = 1.7;
  const std::array<Vec3d, 3> sheared{Vec3d{5, 5, 5}, Vec3d{6, 5, 5}, Vec3d{5 + gamma, 5, 6}};
  EXPECT_NEAR(triangle_stretch(rest, sheared).value(), gamma / 2 + std::sqrt(1 + gamma * gamma / 4), 1e-14);
  EXPECT_NEAR(triangle_stretch(rest, rest).value(), 1, 1e-14);
  EXPECT_FALSE(triangle_stretch({Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{2, 0, 0}}, rest));
}

TEST(VertexStretches, TakeTheGreatestTriangle) {
  const std::vector<Vec3d> rest{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {9, 9, 9}};
  std::vector<Vec3d> now = rest;
  now[3] = {3, 3, 0};
  const std::vector<float> s = vertex_stretches(std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}, rest, now);
  EXPECT_EQ(s[0], 1);
  EXPECT_GT(s[1], 2);
  EXPECT_EQ(s[1], s[3]);
  EXPECT_EQ(s[4], 1);
}

TEST(Zone, OfABendWantsAWidthForAngleAndReach) {
  const Surface surface = cylinder();
  const Stroke thin = bend(60, 0.3);
  const ZoneProfile profile = zone_profile(thin, surface.positions, surface.triangles);
  const ZoneCheck check = check_zone(thin, profile).value();
  EXPECT_NEAR(check.extent, 0.5, 1e-3);
  EXPECT_EQ(check.width, 0.3);
  EXPECT_NEAR(check.safe, 2.4 * 60 * kDegree * 0.5, 1e-3);
  EXPECT_TRUE(check.is_too_thin);
  const Stroke safe = with_safe_zone(thin, profile);
  EXPECT_FALSE(check_zone(safe, profile)->is_too_thin);
  EXPECT_EQ(with_safe_zone(safe, profile), safe);
  EXPECT_LT(edge_stretch(safe, surface), 2.5);
  EXPECT_GT(edge_stretch(thin, surface), 10);
  const std::string warning = zone_warning(thin, profile).value();
  EXPECT_NE(warning.find("0.3 wide"), std::string::npos) << warning;
  EXPECT_NE(warning.find("make the zone 1.26 wide"), std::string::npos) << warning;
  EXPECT_FALSE(zone_warning(safe, profile));
}

TEST(Zone, OfABendChoosesTheGaugeByTheCrossSection) {
  for (const double width : {0.5, 1.5, 2.0, 4.0, 9.0}) {
    for (const double angle_deg : {30.0, 90.0}) {
      for (const bool is_round : {false, true}) {
        const std::vector<Vec3d> points = bar(width, is_round);
        const BendStroke stroke = bend(angle_deg, 0.1);
        const ZoneProfile profile = zone_profile(stroke, points, {});
        const auto safe = std::get<BendStroke>(with_safe_zone(stroke, profile));
        EXPECT_EQ(with_safe_zone(safe, profile), Stroke(safe));
        const double chosen = greatest_of(safe, points);
        for (const double gauge : {0.0, 0.25, 0.5, 0.75, 1.0}) {
          BendStroke other = safe;
          other.gauge = gauge;
          EXPECT_LT(chosen, (is_round ? 1.18 : 1.12) * greatest_of(other, points))
              << width << ", gauge " << gauge << ", " << angle_deg;
        }
      }
    }
  }
}

TEST(Zone, WarnsOfAGaugeThatStretchesFar) {
  const std::vector<Vec3d> plate = bar(8);
  BendStroke stroke = bend(45, 1);
  const std::string warning = zone_warning(stroke, zone_profile(stroke, plate, {})).value();
  EXPECT_NE(warning.find("use 0"), std::string::npos) << warning;
  stroke.gauge = 0.3;
  EXPECT_EQ(with_safe_zone(stroke, zone_profile(stroke, plate, {})), Stroke(stroke)) << "it was given";
  EXPECT_FALSE(zone_warning(stroke, zone_profile(stroke, plate, {})));
  stroke = bend(45, 4);
  EXPECT_FALSE(zone_warning(stroke, zone_profile(stroke, plate, {}))) << "wide zones stretch little";
  stroke = bend(45, 1);
  EXPECT_FALSE(zone_warning(stroke, zone_profile(stroke, bar(1.5), {})));
}

// A safe zone stretches about as much for every falloff as for the default.
TEST(Zone, IsSafeForEveryFalloff) {
  const Surface surface = cylinder();
  for (Stroke stroke : {Stroke(bend(60, 0.3)), Stroke(TwistStroke{{0, 0, 0}, {0, 0, 1}, 400, -0.25, 0.25})}) {
    const ZoneProfile profile = zone_profile(stroke, surface.positions, surface.triangles);
    const double usual = edge_stretch(with_safe_zone(stroke, profile), surface);
    for (const int falloff : {3, 5, 6, 7}) {
      set_falloff(stroke, falloff);
      const Stroke safe = with_safe_zone(stroke, profile);
      EXPECT_FALSE(check_zone(safe, profile)->is_too_thin) << falloff;
      EXPECT_NEAR(edge_stretch(safe, surface), usual, 0.15 * usual) << tool_name(stroke) << falloff;
    }
  }
}

TEST(Zone, WithALimitCylinderGrowsAwayFromItsOuterBorder) {
  const Surface surface = cylinder();
  BendStroke stroke = bend(60, 0.3);
  stroke.extent = BendThresholds{-0.1, 0.2};
  stroke.radius = 0.6;
  const ZoneProfile profile = zone_profile(stroke, surface.positions, surface.triangles);
  const auto safe = std::get<BendStroke>(with_safe_zone(stroke, profile));
  const auto zone = std::get<BendThresholds>(safe.extent);
  EXPECT_GT(zone.outer - zone.inner, 1.2);
  EXPECT_NEAR(-safe.center.z + zone.outer, 0.2, 1e-12);
  EXPECT_NEAR(zone.inner / zone.outer, -0.5, 1e-12);
}

TEST(Zone, OfATwistTurnsTheSameAngleOverMore) {
  const Surface surface = cylinder();
  const TwistStroke stroke{{0, 0, 0}, {0, 0, 1}, 720, -0.25, 0.25};
  const ZoneProfile profile = zone_profile(stroke, surface.positions, surface.triangles);
  const ZoneCheck check = check_zone(stroke, profile).value();
  const double gamma = 720 * kDegree * 0.5;
  EXPECT_NEAR(check.stretch, gamma / 2 + std::sqrt(1 + gamma * gamma / 4), 1e-2);
  EXPECT_TRUE(check.is_too_thin);
  const auto safe = std::get<TwistStroke>(with_safe_zone(stroke, profile));
  EXPECT_NEAR(safe.rate_deg * (safe.outer - safe.inner), 360, 1e-9);
  EXPECT_NEAR(check_zone(safe, profile)->stretch, 2, 1e-2);
  EXPECT_TRUE(zone_warning(stroke, profile).has_value());
}

TEST(Zone, AnEdgeReachesOverItsPartOfTheMotion) {
  const std::vector<Vec3d> positions{{1, 0, -1}, {1, 0, 1}, {0, 1, 1}, {1, 0, 5}};
  const std::vector<Triangle> triangles{{0, 1, 2}};
  TwistStroke twist{{0, 0, 0}, {0, 0, 1}, 30, -3, 3};
  EXPECT_NEAR(most_turn_of_an_edge_deg(twist, positions, triangles), 60, 1e-9);
  EXPECT_NEAR(most_turn_of_an_edge_deg(twist, positions, std::vector<Triangle>{{1, 2, 3}}), 60, 1e-9) << "up to 3";
  twist.radius = 0.5;
  EXPECT_EQ(most_turn_of_an_edge_deg(twist, positions, triangles), 0) << "beyond the limit cylinder";
  EXPECT_EQ(most_turn_of_an_edge_deg(RotateStroke{}, positions, triangles), 0);
}

// What a thin zone misses may reach far and come into the zone while it turns.
TEST(Zone, CountsWhatTurnsIntoIt) {
  const std::vector<Vec3d> positions{{0, 0.1, 0}, {0, -0.1, 0.01}, {0, 2, 0.5}, {0, 3, 4}};
  const ZoneProfile profile = zone_profile(bend(60, 0.1), positions, {});
  EXPECT_NEAR(check_zone(bend(1, 0.1), profile)->extent, 0.1, 1e-12);
  EXPECT_NEAR(check_zone(bend(60, 0.1), profile)->extent, 2, 1e-12);
}

TEST(Zone, IsOfItsOwnLineOnly) {
  const Surface surface = cylinder(2000);
  const ZoneProfile profile = zone_profile(bend(60, 1), surface.positions, surface.triangles);
  BendStroke other = bend(60, 1);
  other.center = {0.2, 0, 0};
  EXPECT_FALSE(check_zone(other, profile));
  EXPECT_FALSE(check_zone(ImplicitStroke{{{0, 0, 0}, {1, 0, 0}}, 0.1, 0.2}, profile));
  EXPECT_EQ(with_safe_zone(other, profile), Stroke(other));
  EXPECT_TRUE(zone_profile(ImplicitStroke{}, surface.positions, surface.triangles).extents.empty());
}

// The slices between the vertices of a coarse mesh are not empty.
TEST(Zone, SeesLongEdges) {
  const Surface surface(make_shape(ShapeKind::box, shape_counts(ShapeKind::box).minimum));
  const BendStroke thin{{0.013, 0, 0}, {0, 0, 1}, {-1, 0, 0}, 5, BendWidth{0.005}};
  EXPECT_NEAR(check_zone(thin, zone_profile(thin, surface.positions, surface.triangles))->extent, 0.5, 1e-9);
}

}  // namespace
}  // namespace knead::strain_test
