// The search for a place at which a limit cylinder separates a part.
#include <gtest/gtest.h>

#include <cmath>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "support/surface.h"
#include "support/test_meshes.h"

namespace knead::cylinder_placement_test {
namespace {

using test::Surface;

BendStroke bend_at(const CylinderPlacement& limit_cylinder, const Vec3d& axis, double angle_deg) {
  BendStroke stroke{limit_cylinder.center, axis, limit_cylinder.normal, angle_deg,
                    BendThresholds{limit_cylinder.inner, limit_cylinder.outer}};
  stroke.radius = limit_cylinder.radius;
  return stroke;
}

CylinderCheck check(const Stroke& stroke, const Surface& surface) {
  return check_limit_cylinder(limit_cylinder_of(stroke).value(), surface.positions, surface.triangles);
}

// Moves the surface; returns by how much each vertex went.
std::vector<double> distances_moved(const Stroke& stroke, const Surface& surface) {
  std::vector<Vec3d> after = surface.positions;
  AdvectOptions options;
  options.tolerance = 1e-5 * bounding_box(after).diagonal();
  EXPECT_EQ(advect(flow_of(stroke), after, options).status, AdvectStatus::done);
  std::vector<double> result;
  for (std::size_t i = 0; i < after.size(); ++i) result.push_back(norm(after[i] - surface.positions[i]));
  return result;
}

// Bends and twists of the part cross nothing, and exactly what is joined to its tip moves.
void expect_moves_alone(const CylinderQuery& query, const Surface& surface) {
  const CylinderPlacement limit_cylinder = place_limit_cylinder(query, surface.positions, surface.triangles);
  ASSERT_TRUE(limit_cylinder.problem.empty()) << limit_cylinder.problem;
  EXPECT_GT(dot(limit_cylinder.center - query.point, query.direction), -1e-12);
  EXPECT_LT(limit_cylinder.inner, 0);
  EXPECT_GT(limit_cylinder.outer, 0);
  const BendStroke bend = bend_at(limit_cylinder, query.axis, query.angle_deg);
  BendStroke automatic = bend;
  automatic.radius.reset();
  automatic.radius_auto = true;
  std::vector<std::string> remarks;
  const Stroke found = with_found_radius(automatic, surface.positions, surface.triangles, remarks);
  EXPECT_NEAR(std::get<BendStroke>(found).radius.value() / limit_cylinder.radius, 1,
              0.01);  // three digits, of the same gap
  TwistStroke twist{limit_cylinder.center, limit_cylinder.normal, 20 / limit_cylinder.thickness, limit_cylinder.inner,
                    limit_cylinder.outer};
  twist.radius = limit_cylinder.radius;
  const std::vector<double> bent = distances_moved(bend, surface);
  EXPECT_EQ(check(bend, surface).crossing, 0u);
  EXPECT_EQ(check(twist, surface).crossing, 0u);
  std::size_t moved = 0;
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < bent.size(); ++i) {
    const Vec3d d = surface.positions[i] - limit_cylinder.center;
    const double r = dot(limit_cylinder.normal, d);
    const bool within = norm(d - limit_cylinder.normal * r) <= limit_cylinder.radius;
    if (within && r < limit_cylinder.inner && bent[i] > 0) ++moved;
    if (!within && bent[i] > 0) ++elsewhere;
  }
  EXPECT_GT(moved, 30u);
  EXPECT_LT(moved, surface.positions.size() / 4);
  EXPECT_EQ(elsewhere, 0u);
}

TEST(PlaceLimitCylinder, MovesEveryFingerOfTheHandAlone) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  for (const Finger& finger : hand_fingers()) {
    SCOPED_TRACE(finger.name);
    const Vec3d across = normalized(cross(finger.axis, Vec3d{0, 0, 1}));
    expect_moves_alone({finger.base + finger.axis * (0.2 * finger.length), finger.axis, across, 50}, hand);
  }
}

TEST(PlaceLimitCylinder, FromTheRootGoesOnToWhereTheFingerIsFree) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  const Finger& finger = hand_fingers()[2];
  const CylinderPlacement limit_cylinder =
      place_limit_cylinder({finger.base - finger.axis * 0.05, finger.axis}, hand.positions, hand.triangles);
  ASSERT_TRUE(limit_cylinder.problem.empty()) << limit_cylinder.problem;
  const double height =
      dot(finger.axis, limit_cylinder.center + limit_cylinder.normal * limit_cylinder.outer - finger.base);
  EXPECT_GT(height, -0.1);
  EXPECT_LT(height, 0.3 * finger.length);
}

TEST(PlaceLimitCylinder, IsAtThePointWhereThatWillDo) {
  const Surface bar(make_shape(ShapeKind::box, 3000));
  const CylinderPlacement limit_cylinder =
      place_limit_cylinder({{0.5, 0.1, 0}, {2, 0, 0}}, bar.positions, bar.triangles);
  ASSERT_TRUE(limit_cylinder.problem.empty()) << limit_cylinder.problem;
  EXPECT_EQ(limit_cylinder.center, Vec3d(0.5, 0.1, 0));
  EXPECT_EQ(limit_cylinder.normal, Vec3d(-1, 0, 0));
  EXPECT_NEAR(limit_cylinder.thickness, std::sqrt(0.6 * 0.6 + 0.5 * 0.5), 1e-12);
  EXPECT_NEAR(limit_cylinder.outer - limit_cylinder.inner, 2 * limit_cylinder.thickness, 1e-12);
  EXPECT_NEAR(-limit_cylinder.inner, kCenterFraction * 2 * limit_cylinder.thickness, 1e-12);
}

TEST(PlaceLimitCylinder, SaysThatThePointLiesInNone) {
  const Surface bar(make_shape(ShapeKind::box, 600));
  for (const Vec3d& point : {Vec3d{0, 0, 2}, Vec3d{5, 0, 0}}) {
    const CylinderPlacement limit_cylinder = place_limit_cylinder({point, {1, 0, 0}}, bar.positions, bar.triangles);
    EXPECT_TRUE(limit_cylinder.problem.starts_with("there is no limb at this point")) << limit_cylinder.problem;
  }
}

// A ring is nowhere a part that can be moved alone: a plane across it leaves it joined to the rest in two places.
TEST(PlaceLimitCylinder, SaysWhyThereIsNoPlace) {
  const Surface torus(make_shape(ShapeKind::torus, 3000));
  const CylinderPlacement limit_cylinder =
      place_limit_cylinder({{1, 0, 0}, {0, 1, 0}}, torus.positions, torus.triangles);
  EXPECT_TRUE(limit_cylinder.problem.starts_with("from the point to the tip there is no place"))
      << limit_cylinder.problem;
}

TEST(PlaceLimitCylinder, IsRefusedWithoutADirection) {
  EXPECT_THROW(place_limit_cylinder({{0, 0, 0}, {0, 0, 0}}, {}, {}), InvalidInput);
}

struct ScannedPart {
  std::string mesh;
  std::string name;
  CylinderQuery query;

  friend std::ostream& operator<<(std::ostream& out, const ScannedPart& part) { return out << part.name; }
};

class PartOfAScan : public testing::TestWithParam<ScannedPart> {};

TEST_P(PartOfAScan, MovesAlone) {
  KNEAD_NEEDS_TEST_MESH(GetParam().mesh);
  expect_moves_alone(GetParam().query, Surface(read_shape(test_mesh(GetParam().mesh)).mesh));
}

INSTANTIATE_TEST_SUITE_P(
    PlaceLimitCylinder, PartOfAScan,
    testing::Values(
        ScannedPart{"hand_50k.ply", "middle", {{-2.2, 0.74, 0.5}, {-0.86, -0.41, 0.07}, {0, 0.07, 0.41}, 40}},
        ScannedPart{"hand_50k.ply", "index", {{-2.2, 0.8, 1.37}, {-0.87, -0.47, 0.12}, {0, 0.12, 0.47}, 40}},
        ScannedPart{"hand_50k.ply", "little", {{-2.2, 0.2, -1.1}, {-0.44, -0.29, 0.06}, {0, 0.06, 0.29}, 40}},
        ScannedPart{"hand_50k.ply", "thumb", {{-0.036, -0.35, 2.38}, {-0.5, -0.5, 0.27}, {1, -1, 0}, 30}},
        ScannedPart{"armadillo_43k.ply", "left_leg", {{0.19, -0.28, -0.06}, {0, -1, 0}, {1, 0, 0}, 45}},
        ScannedPart{"armadillo_43k.ply", "right_leg", {{-0.175, -0.28, -0.06}, {0, -1, 0}, {1, 0, 0}, 45}},
        ScannedPart{"armadillo_43k.ply", "tail", {{0.009, -0.26, -0.352}, {0, -0.3, -1}, {1, 0, 0}, 40}}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace knead::cylinder_placement_test
