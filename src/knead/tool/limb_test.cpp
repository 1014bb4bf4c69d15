#include <gtest/gtest.h>

#include <cmath>

#include "knead/flow/advect.h"
#include "knead/io/shape_file.h"
#include "knead/math/box.h"
#include "knead/math/error.h"
#include "knead/mesh/shapes.h"
#include "knead/tool/placement.h"
#include "support/surface.h"
#include "support/test_meshes.h"

namespace knead {
namespace {

using test::Surface;

BendStroke bend_at(const LimbProposal& limb, const Vec3d& axis, double angle_deg) {
  BendStroke stroke{limb.center, axis, limb.normal, angle_deg, Thresholds<double>{limb.inner, limb.outer}};
  stroke.radius = limb.radius;
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

// Bends and twists of the limb cross nothing, and what moves is what is joined to the limb's tip.
void expect_moves_alone(const LimbQuery& query, const Surface& surface) {
  const LimbProposal limb = propose_limb(query, surface.positions, surface.triangles);
  ASSERT_TRUE(limb.problem.empty()) << limb.problem;
  EXPECT_GT(dot(limb.center - query.point, query.direction), -1e-12);
  EXPECT_LT(limb.inner, 0);
  EXPECT_GT(limb.outer, 0);
  const BendStroke bend = bend_at(limb, query.axis, query.angle_deg);
  BendStroke automatic = bend;
  automatic.radius.reset();
  automatic.radius_auto = true;
  std::vector<std::string> remarks;
  const Stroke found = with_found_radius(automatic, surface.positions, surface.triangles, remarks);
  EXPECT_NEAR(std::get<BendStroke>(found).radius.value() / limb.radius, 1, 0.01);  // three digits, of the same gap
  TwistStroke twist{limb.center, limb.normal, 20 / limb.thickness, limb.inner, limb.outer};
  twist.radius = limb.radius;
  const std::vector<double> bent = distances_moved(bend, surface);
  EXPECT_EQ(check(bend, surface).crossing, 0u);
  EXPECT_EQ(check(twist, surface).crossing, 0u);
  std::size_t moved = 0;
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < bent.size(); ++i) {
    const Vec3d d = surface.positions[i] - limb.center;
    const double r = dot(limb.normal, d);
    const bool within = norm(d - limb.normal * r) <= limb.radius;
    if (within && r < limb.inner && bent[i] > 0) ++moved;
    if (!within && bent[i] > 0) ++elsewhere;
  }
  EXPECT_GT(moved, 30u);
  EXPECT_LT(moved, surface.positions.size() / 4);
  EXPECT_EQ(elsewhere, 0u);
}

TEST(ProposeLimb, MovesEveryFingerOfTheHandAlone) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  for (const Finger& finger : hand_fingers()) {
    SCOPED_TRACE(finger.name);
    const Vec3d across = normalized(cross(finger.axis, Vec3d{0, 0, 1}));
    expect_moves_alone({finger.base + finger.axis * (0.2 * finger.length), finger.axis, across, 50}, hand);
  }
}

TEST(ProposeLimb, FromTheRootGoesOnToWhereTheFingerIsFree) {
  const Surface hand(make_shape(ShapeKind::hand, 8000));
  const Finger& finger = hand_fingers()[2];
  const LimbProposal limb =
      propose_limb({finger.base - finger.axis * 0.05, finger.axis}, hand.positions, hand.triangles);
  ASSERT_TRUE(limb.problem.empty()) << limb.problem;
  const double height = dot(finger.axis, limb.center + limb.normal * limb.outer - finger.base);
  EXPECT_GT(height, -0.1);
  EXPECT_LT(height, 0.3 * finger.length);
}

TEST(ProposeLimb, IsAtThePointWhereThatWillDo) {
  const Surface bar(make_shape(ShapeKind::box, 3000));
  const LimbProposal limb = propose_limb({{0.5, 0.1, 0}, {2, 0, 0}}, bar.positions, bar.triangles);
  ASSERT_TRUE(limb.problem.empty()) << limb.problem;
  EXPECT_EQ(limb.center, Vec3d(0.5, 0.1, 0));
  EXPECT_EQ(limb.normal, Vec3d(-1, 0, 0));
  EXPECT_NEAR(limb.thickness, std::sqrt(0.6 * 0.6 + 0.5 * 0.5), 1e-12);
  EXPECT_NEAR(limb.outer - limb.inner, 2 * limb.thickness, 1e-12);
  EXPECT_NEAR(-limb.inner, kCenterFraction * 2 * limb.thickness, 1e-12);
}

TEST(ProposeLimb, SaysThatThePointLiesInNone) {
  const Surface bar(make_shape(ShapeKind::box, 600));
  for (const Vec3d& point : {Vec3d{0, 0, 2}, Vec3d{5, 0, 0}}) {
    const LimbProposal limb = propose_limb({point, {1, 0, 0}}, bar.positions, bar.triangles);
    EXPECT_TRUE(limb.problem.starts_with("the point lies in no limb")) << limb.problem;
  }
}

// A ring is nowhere a limb: a plane across it leaves it hanging on two places.
TEST(ProposeLimb, SaysWhyThereIsNoPlace) {
  const Surface torus(make_shape(ShapeKind::torus, 3000));
  const LimbProposal limb = propose_limb({{1, 0, 0}, {0, 1, 0}}, torus.positions, torus.triangles);
  EXPECT_TRUE(limb.problem.starts_with("from the point to the tip there is no place")) << limb.problem;
}

TEST(ProposeLimb, IsRefusedWithoutADirection) {
  EXPECT_THROW(propose_limb({{0, 0, 0}, {0, 0, 0}}, {}, {}), InvalidInput);
}

struct ScannedLimb {
  std::string mesh;
  std::string name;
  LimbQuery query;
};

class LimbOfAScan : public testing::TestWithParam<ScannedLimb> {};

TEST_P(LimbOfAScan, MovesAlone) {
  KNEAD_NEEDS_TEST_MESH(GetParam().mesh);
  expect_moves_alone(GetParam().query, Surface(read_shape(test_mesh(GetParam().mesh)).mesh));
}

INSTANTIATE_TEST_SUITE_P(
    ProposeLimb, LimbOfAScan,
    testing::Values(
        ScannedLimb{"hand_50k.ply", "middle", {{-2.2, 0.74, 0.5}, {-0.86, -0.41, 0.07}, {0, 0.07, 0.41}, 40}},
        ScannedLimb{"hand_50k.ply", "index", {{-2.2, 0.8, 1.37}, {-0.87, -0.47, 0.12}, {0, 0.12, 0.47}, 40}},
        ScannedLimb{"hand_50k.ply", "little", {{-2.2, 0.2, -1.1}, {-0.44, -0.29, 0.06}, {0, 0.06, 0.29}, 40}},
        ScannedLimb{"hand_50k.ply", "thumb", {{-0.036, -0.35, 2.38}, {-0.5, -0.5, 0.27}, {1, -1, 0}, 30}},
        ScannedLimb{"armadillo_43k.ply", "left_leg", {{0.19, -0.28, -0.06}, {0, -1, 0}, {1, 0, 0}, 45}},
        ScannedLimb{"armadillo_43k.ply", "right_leg", {{-0.175, -0.28, -0.06}, {0, -1, 0}, {1, 0, 0}, 45}},
        ScannedLimb{"armadillo_43k.ply", "tail", {{0.009, -0.26, -0.352}, {0, -0.3, -1}, {1, 0, 0}, 40}}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace knead
