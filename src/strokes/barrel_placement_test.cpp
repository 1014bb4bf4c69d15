#include <gtest/gtest.h>

#include <cmath>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/tools.h"
#include "knead/vec.h"
#include "support/surface.h"
#include "support/test_meshes.h"

namespace knead {
namespace {

using test::Surface;

BendStroke bend_at(const BarrelPlacement& barrel, const Vec3d& axis, double angle_deg) {
  BendStroke stroke{barrel.center, axis, barrel.normal, angle_deg, BendThresholds{barrel.inner, barrel.outer}};
  stroke.radius = barrel.radius;
  return stroke;
}

BarrelCheck check(const Stroke& stroke, const Surface& surface) {
  return check_barrel(barrel_of(stroke).value(), surface.positions, surface.triangles);
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
void expect_moves_alone(const BarrelQuery& query, const Surface& surface) {
  const BarrelPlacement barrel = place_barrel(query, surface.positions, surface.triangles);
  ASSERT_TRUE(barrel.problem.empty()) << barrel.problem;
  EXPECT_GT(dot(barrel.center - query.point, query.direction), -1e-12);
  EXPECT_LT(barrel.inner, 0);
  EXPECT_GT(barrel.outer, 0);
  const BendStroke bend = bend_at(barrel, query.axis, query.angle_deg);
  BendStroke automatic = bend;
  automatic.radius.reset();
  automatic.radius_auto = true;
  std::vector<std::string> remarks;
  const Stroke found = with_found_radius(automatic, surface.positions, surface.triangles, remarks);
  EXPECT_NEAR(std::get<BendStroke>(found).radius.value() / barrel.radius, 1, 0.01);  // three digits, of the same gap
  TwistStroke twist{barrel.center, barrel.normal, 20 / barrel.thickness, barrel.inner, barrel.outer};
  twist.radius = barrel.radius;
  const std::vector<double> bent = distances_moved(bend, surface);
  EXPECT_EQ(check(bend, surface).crossing, 0u);
  EXPECT_EQ(check(twist, surface).crossing, 0u);
  std::size_t moved = 0;
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < bent.size(); ++i) {
    const Vec3d d = surface.positions[i] - barrel.center;
    const double r = dot(barrel.normal, d);
    const bool within = norm(d - barrel.normal * r) <= barrel.radius;
    if (within && r < barrel.inner && bent[i] > 0) ++moved;
    if (!within && bent[i] > 0) ++elsewhere;
  }
  EXPECT_GT(moved, 30u);
  EXPECT_LT(moved, surface.positions.size() / 4);
  EXPECT_EQ(elsewhere, 0u);
}

TEST(PlaceBarrel, MovesEveryFingerOfTheHandAlone) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  for (const Finger& finger : hand_fingers()) {
    SCOPED_TRACE(finger.name);
    const Vec3d across = normalized(cross(finger.axis, Vec3d{0, 0, 1}));
    expect_moves_alone({finger.base + finger.axis * (0.2 * finger.length), finger.axis, across, 50}, hand);
  }
}

TEST(PlaceBarrel, FromTheRootGoesOnToWhereTheFingerIsFree) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  const Finger& finger = hand_fingers()[2];
  const BarrelPlacement barrel =
      place_barrel({finger.base - finger.axis * 0.05, finger.axis}, hand.positions, hand.triangles);
  ASSERT_TRUE(barrel.problem.empty()) << barrel.problem;
  const double height = dot(finger.axis, barrel.center + barrel.normal * barrel.outer - finger.base);
  EXPECT_GT(height, -0.1);
  EXPECT_LT(height, 0.3 * finger.length);
}

TEST(PlaceBarrel, IsAtThePointWhereThatWillDo) {
  const Surface bar(make_shape(ShapeKind::box, 3000));
  const BarrelPlacement barrel = place_barrel({{0.5, 0.1, 0}, {2, 0, 0}}, bar.positions, bar.triangles);
  ASSERT_TRUE(barrel.problem.empty()) << barrel.problem;
  EXPECT_EQ(barrel.center, Vec3d(0.5, 0.1, 0));
  EXPECT_EQ(barrel.normal, Vec3d(-1, 0, 0));
  EXPECT_NEAR(barrel.thickness, std::sqrt(0.6 * 0.6 + 0.5 * 0.5), 1e-12);
  EXPECT_NEAR(barrel.outer - barrel.inner, 2 * barrel.thickness, 1e-12);
  EXPECT_NEAR(-barrel.inner, kCenterFraction * 2 * barrel.thickness, 1e-12);
}

TEST(PlaceBarrel, SaysThatThePointLiesInNone) {
  const Surface bar(make_shape(ShapeKind::box, 600));
  for (const Vec3d& point : {Vec3d{0, 0, 2}, Vec3d{5, 0, 0}}) {
    const BarrelPlacement barrel = place_barrel({point, {1, 0, 0}}, bar.positions, bar.triangles);
    EXPECT_TRUE(barrel.problem.starts_with("there is no limb at this point")) << barrel.problem;
  }
}

// A ring is nowhere a part that can be moved alone: a plane across it leaves it joined to the rest in two places.
TEST(PlaceBarrel, SaysWhyThereIsNoPlace) {
  const Surface torus(make_shape(ShapeKind::torus, 3000));
  const BarrelPlacement barrel = place_barrel({{1, 0, 0}, {0, 1, 0}}, torus.positions, torus.triangles);
  EXPECT_TRUE(barrel.problem.starts_with("from the point to the tip there is no place")) << barrel.problem;
}

TEST(PlaceBarrel, IsRefusedWithoutADirection) {
  EXPECT_THROW(place_barrel({{0, 0, 0}, {0, 0, 0}}, {}, {}), InvalidInput);
}

struct ScannedPart {
  std::string mesh;
  std::string name;
  BarrelQuery query;
};

class PartOfAScan : public testing::TestWithParam<ScannedPart> {};

TEST_P(PartOfAScan, MovesAlone) {
  KNEAD_NEEDS_TEST_MESH(GetParam().mesh);
  expect_moves_alone(GetParam().query, Surface(read_shape(test_mesh(GetParam().mesh)).mesh));
}

INSTANTIATE_TEST_SUITE_P(
    PlaceBarrel, PartOfAScan,
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
}  // namespace knead
