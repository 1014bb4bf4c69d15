// Limit cylinders: crossed and torn triangles, and suggested radii.
#include "knead/editor/tools.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "knead/mesh.h"

namespace knead::limit_cylinder_test {
namespace {

// An open tube about the z axis from z = 0 to 1: every vertex has exactly the distance `radius` for four columns.
struct Surface {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;

  void add_square_tube(double radius) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const double z : {0.0, 1.0}) {
      for (const Vec3d& p : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{-1, 0, 0}, Vec3d{0, -1, 0}}) {
        positions.push_back(p * radius + Vec3d{0, 0, z});
      }
    }
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t j = (i + 1) % 4;
      triangles.push_back({first + i, first + j, first + 4 + j});
      triangles.push_back({first + i, first + 4 + j, first + 4 + i});
    }
  }
};

StrokeCylinder limit_cylinder_about_z(double radius, double outer) {
  return {{0, 0, 0}, {0, 0, 1}, radius, outer, {0, 0, 1}};
}

CylinderCheck check(const Surface& surface, double radius, double outer = 10) {
  return check_limit_cylinder(limit_cylinder_about_z(radius, outer), surface.positions, surface.triangles);
}

TEST(StrokeCylinder, IsCrossedWhereASurfaceComesNearerAndGoesFarther) {
  Surface tube;
  tube.add_square_tube(2);  // distances from sqrt(2), at the middle of its faces, to 2
  EXPECT_EQ(check(tube, 1.7).crossing, 8u);
  EXPECT_EQ(check(tube, 1.4).crossing, 0u);
  EXPECT_EQ(check(tube, 2.0).crossing, 0u);  // vertices at the radius itself belong to what is moved
  EXPECT_EQ(check(tube, std::nextafter(2.0, 0.0)).crossing, 8u);
  EXPECT_FALSE(check(tube, 2.0).larger);
}

TEST(StrokeCylinder, ATriangleBeyondThatTouchesTheRadiusWithAVertexIsTorn) {
  const Surface fin{{{1, 0, 0}, {2, 0, 0}, {2, 0, 1}}, {{0, 1, 2}}};
  EXPECT_EQ(check(fin, 1).crossing, 1u);
  EXPECT_EQ(check(fin, std::nextafter(1.0, 0.0)).crossing, 0u);
}

TEST(StrokeCylinder, CountsOnlyWhereThingsMove) {
  Surface tube;
  tube.add_square_tube(2);
  EXPECT_EQ(check(tube, 1.7, 0.0).crossing, 0u);   // r < 0 holds nothing
  EXPECT_EQ(check(tube, 1.7, 1e-9).crossing, 4u);  // those that have an edge at r = 0
  // Of a triangle whose far corner alone is above r = 0.5, only the near part counts.
  const Surface slope{{{0.1, 0, 0}, {0.1, 0.1, 0}, {3, 0, 1}}, {{0, 1, 2}}};
  EXPECT_EQ(check(slope, 1, 2).crossing, 1u);
  EXPECT_EQ(check(slope, 1, 0.2).crossing, 0u);  // at r = 0.2 it is 0.68 from the axis
  EXPECT_EQ(check(slope, 0.6, 0.2).crossing, 1u);
}

TEST(StrokeCylinder, ADiscThatTheAxisPiercesBeginsAtZero) {
  const Surface disc{{{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}}, {{0, 1, 2}}};
  const CylinderCheck found = check(disc, 0.1);
  EXPECT_EQ(found.crossing, 1u);
  EXPECT_FALSE(found.smaller);
  ASSERT_TRUE(found.larger);
  EXPECT_NEAR(*found.larger, std::sqrt(10.0), 1.1e-5);
  EXPECT_EQ(nearest_radius(found, 0.1), found.larger);
}

TEST(StrokeCylinder, SeenEdgeOnATriangleBeginsAtItsEdges) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  for (int i = 0; i < 100; ++i) {
    const double phi = angle(random);
    const Vec3d out{std::cos(phi), std::sin(phi), 0};
    const Surface fin{{out * 0.5, out * 2.0, out * 1.0 + Vec3d{0, 0, 1}}, {{0, 1, 2}}};
    EXPECT_EQ(check(fin, 0.4).crossing, 0u);
    EXPECT_EQ(check(fin, 1.5).crossing, 1u);
  }
}

TEST(StrokeCylinder, SuggestsRadiiInTheGapsThatWork) {
  Surface tubes;  // distances 0.7071 to 1, 1.414 to 2, 2.12 to 3
  for (const double radius : {1.0, 2.0, 3.0}) tubes.add_square_tube(radius);
  const CylinderCheck found = check(tubes, 1.9);
  EXPECT_EQ(found.crossing, 8u);
  ASSERT_TRUE(found.smaller);
  ASSERT_TRUE(found.larger);
  EXPECT_NEAR(*found.smaller, std::sqrt(2.0), 1.1e-5);
  EXPECT_NEAR(*found.larger, 2, 1.1e-5);
  EXPECT_EQ(check(tubes, *found.smaller).crossing, 0u);
  EXPECT_EQ(check(tubes, *found.larger).crossing, 0u);
  EXPECT_EQ(nearest_radius(found, 1.9), found.larger);
  EXPECT_EQ(nearest_radius(check(tubes, 1.5), 1.5), found.smaller);
  EXPECT_FALSE(check(tubes, 0.8).smaller);  // nothing would be left inside
}

TEST(StrokeCylinder, SuggestionsWorkOnRandomSoup) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> place(-3, 3);
  std::uniform_real_distribution<double> size(-0.1, 0.1);
  int suggested = 0;
  for (int round = 0; round < 200; ++round) {
    Surface soup;
    for (std::uint32_t i = 0; i < 20; ++i) {
      const Vec3d p{place(random), place(random), place(random)};
      for (int k = 0; k < 3; ++k) soup.positions.push_back(p + Vec3d{size(random), size(random), size(random)});
      soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const double radius = std::abs(place(random));
    const CylinderCheck found = check(soup, radius, 1);
    EXPECT_EQ(found.crossing > 0, found.larger.has_value());
    for (const std::optional<double>& other : {found.smaller, found.larger}) {
      if (!other) continue;
      ++suggested;
      EXPECT_EQ(check(soup, *other, 1).crossing, 0u) << "seed 4, round " << round;
      EXPECT_EQ(other == found.smaller, *other < radius);
    }
  }
  EXPECT_GT(suggested, 50);
}

TEST(StrokeCylinder, OfACylinderShapeIsItsRadius) {
  const Mesh mesh = make_shape(ShapeKind::cylinder, 2000);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const CylinderCheck found = check_limit_cylinder(limit_cylinder_about_z(0.3, 1), mesh.positions, triangles);
  EXPECT_GT(found.crossing, 0u);
  EXPECT_FALSE(found.smaller);  // the bottom disc covers every smaller radius
  ASSERT_TRUE(found.larger);
  EXPECT_NEAR(*found.larger, 0.5, 2e-6);
  EXPECT_EQ(check_limit_cylinder(limit_cylinder_about_z(*found.larger, 1), mesh.positions, triangles).crossing, 0u);
}

TEST(StrokeCylinder, NoticesWhatABendReachesLater) {
  BendStroke stroke{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 60, BendThresholds{-1, 0.5}};
  stroke.radius = 1.7;
  const std::optional<StrokeCylinder> limit_cylinder = limit_cylinder_of(stroke);
  ASSERT_TRUE(limit_cylinder);
  EXPECT_EQ(limit_cylinder->normal, Vec3d(0, 0, 1));
  EXPECT_LE(norm(limit_cylinder->last_normal - Vec3d{0.5, 0, std::sqrt(0.75)}), 1e-14);
  const Surface flap{{{-1.5, 0, 0.6}, {-1.5, 0.2, 0.6}, {-2, 0, 0.7}}, {{0, 1, 2}}};
  const CylinderCheck found = check_limit_cylinder(*limit_cylinder, flap.positions, flap.triangles);
  EXPECT_EQ(found.crossing, 0u);
  EXPECT_EQ(found.later, 1u);
}

TEST(StrokeCylinder, IsThatOfStrokesWithARadiusOnly) {
  TwistStroke twist{{1, 2, 3}, {0, 0, 2}, 30, -1, 1};
  EXPECT_FALSE(limit_cylinder_of(twist));
  twist.radius = 0.7;
  EXPECT_EQ(limit_cylinder_of(twist), (StrokeCylinder{{1, 2, 3}, {0, 0, 1}, 0.7, 1, {0, 0, 1}}));
  EXPECT_FALSE(limit_cylinder_of(RotateStroke{{}, {0, 0, 1}, 30, 1, 2}));
}

}  // namespace
}  // namespace knead::limit_cylinder_test
