// Proposed radii of limit cylinders.
#include "knead/editor/tools.h"

#include <gtest/gtest.h>

#include <cmath>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/region.h"
#include "knead/vec.h"
#include "support/random_fields.h"
#include "support/surface.h"

namespace knead::placement_test {
namespace {

using test::Surface;

const Surface& hand() {
  static const Surface surface(make_shape(ShapeKind::hand, 8000));
  return surface;
}

// About a finger, its plane r = outer through the base.
StrokeCylinder about(const Finger& finger, double outer = 0) {
  return {finger.base, -finger.axis, 0, outer, -finger.axis};
}

// A bend of the finger with an automatic radius; r = 0 a little above the base.
BendStroke bend_of(const Finger& finger, double angle_deg) {
  const Vec3d across = any_orthogonal(finger.axis);
  const double width = 0.3 * finger.length;
  BendStroke stroke{finger.base + finger.axis * (0.9 * width), across, -finger.axis, angle_deg, BendWidth{width}};
  stroke.radius_auto = true;
  return stroke;
}

TEST(ProposeLimitCylinder, FindsTheGapAroundEveryFingerOfTheHand) {
  for (const Finger& finger : hand_fingers()) {
    SCOPED_TRACE(finger.name);
    StrokeCylinder limit_cylinder = about(finger);
    const CylinderProposal proposal = propose_limit_cylinder(limit_cylinder, hand().positions, hand().triangles);
    ASSERT_TRUE(proposal.radius) << proposal.problem;
    EXPECT_LE(proposal.part,
              1.01 * finger.radius);  // what mesh.h says of the fingers, and its triangles across the plane
    EXPECT_GE(proposal.others, finger.radius);
    EXPECT_LT(proposal.part, *proposal.radius);
    EXPECT_LT(*proposal.radius, proposal.others);
    EXPECT_EQ(proposal.within, 0u);
    limit_cylinder.radius = *proposal.radius;
    const CylinderCheck check = check_limit_cylinder(limit_cylinder, hand().positions, hand().triangles);
    EXPECT_EQ(check.crossing, 0u);
    EXPECT_EQ(check.later, 0u);
  }
}

TEST(ProposeLimitCylinder, ThenTheFingerMovesAndNothingElse) {
  for (const Finger& finger : hand_fingers()) {
    SCOPED_TRACE(finger.name);
    std::vector<std::string> remarks;
    const Stroke found = with_found_radius(bend_of(finger, 40), hand().positions, hand().triangles, remarks);
    EXPECT_TRUE(remarks.empty());
    const StrokeCylinder limit_cylinder = limit_cylinder_of(found).value();
    const CylinderCheck check = check_limit_cylinder(limit_cylinder, hand().positions, hand().triangles);
    EXPECT_EQ(check.crossing + check.later, 0u);
    std::vector<Vec3d> after = hand().positions;
    ASSERT_EQ(advect(flow_of(found), after, {.tolerance = 1e-5}).status, AdvectStatus::done);
    int moved = 0;
    for (std::size_t i = 0; i < after.size(); ++i) {
      const Vec3d d = hand().positions[i] - finger.base;
      const double height = dot(finger.axis, d);
      const bool in_finger = height > -0.1 * finger.length && norm(d - finger.axis * height) < finger.radius;
      if (!in_finger) {
        EXPECT_EQ(after[i], hand().positions[i]);
      } else if (height > 0.5 * finger.length) {
        EXPECT_GT(norm(after[i] - hand().positions[i]), 0.01);
        ++moved;
      }
    }
    EXPECT_GT(moved, 50);
  }
}

// Random lines through random shapes: what is proposed crosses nothing, and where nothing is proposed it says why.
TEST(ProposeLimitCylinder, CrossesNothingWhereverItIsAsked) {
  test::Random random(141);
  int proposed = 0;
  int refused = 0;
  for (const ShapeKind kind : {ShapeKind::hand, ShapeKind::knot, ShapeKind::letter_y, ShapeKind::torus}) {
    const Mesh mesh = make_shape(kind, 4000);
    const Surface surface(mesh);
    const double size = bounding_box(mesh.positions).diagonal();
    for (int i = 0; i < 40; ++i) {
      const auto at = static_cast<std::size_t>(random.integer(0, static_cast<int>(mesh.vertex_count()) - 1));
      const Vec3d normal = random.unit();
      const Vec3d axis = any_orthogonal(normal);
      StrokeCylinder limit_cylinder{mesh.positions[at] * 0.9, normal, 0, random.uniform(-0.05, 0.15) * size, normal};
      if (i % 2 == 0) limit_cylinder.last_normal = rotate(normal, axis, sincos(random.uniform(-0.5, 0.5)));
      const CylinderProposal proposal = propose_limit_cylinder(limit_cylinder, surface.positions, surface.triangles);
      EXPECT_EQ(proposal.radius.has_value(), proposal.problem.empty());
      if (!proposal.radius) {
        ++refused;
        continue;
      }
      ++proposed;
      limit_cylinder.radius = *proposal.radius;
      EXPECT_EQ(check_limit_cylinder(limit_cylinder, surface.positions, surface.triangles).crossing, 0u)
          << "seed 141, line " << i;
    }
  }
  EXPECT_GT(proposed, 30);
  EXPECT_GT(refused, 10);
}

TEST(ProposeLimitCylinder, IsTheMiddleOfTheGap) {
  const CylinderProposal proposal =
      propose_limit_cylinder(about(hand_fingers()[2]), hand().positions, hand().triangles);
  ASSERT_TRUE(proposal.radius);
  EXPECT_NEAR(*proposal.radius / std::sqrt(proposal.part * proposal.others), 1, 0.01);  // three digits
}

TEST(ProposeLimitCylinder, OfAShapeAloneIsABitMoreThanItsReach) {
  const Surface cylinder(make_shape(ShapeKind::cylinder, 2000));
  const CylinderProposal proposal =
      propose_limit_cylinder({{0, 0, 0}, {0, 0, 1}, 0, 1, {0, 0, 1}}, cylinder.positions, cylinder.triangles);
  ASSERT_TRUE(proposal.radius);
  EXPECT_NEAR(proposal.part, 0.5, 1e-12);
  EXPECT_EQ(*proposal.radius, 0.625);
  std::vector<std::string> remarks;
  TwistStroke twist{{0, 0, 0}, {0, 0, 1}, 90, -1, 1};
  twist.radius_auto = true;
  const Stroke found = with_found_radius(twist, cylinder.positions, cylinder.triangles, remarks);
  EXPECT_EQ(std::get<TwistStroke>(found).radius, 0.625);
  EXPECT_FALSE(std::get<TwistStroke>(found).radius_auto);
  EXPECT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("it restricts nothing"), std::string::npos);
}

TEST(ProposeLimitCylinder, LeavesOtherStrokesAsTheyAre) {
  std::vector<std::string> remarks;
  TwistStroke twist{{0, 0, 0}, {0, 0, 1}, 90, -1, 1};
  twist.radius = 0.3;
  EXPECT_EQ(with_found_radius(twist, {}, {}, remarks), Stroke(twist));
  const RotateStroke rotate{{0, 0, 0}, {0, 0, 1}, 30, 1, 2};
  EXPECT_EQ(with_found_radius(rotate, {}, {}, remarks), Stroke(rotate));
}

TEST(ProposeLimitCylinder, SaysThatNothingIsThere) {
  const CylinderProposal proposal =
      propose_limit_cylinder(about(hand_fingers()[0], -100), hand().positions, hand().triangles);
  EXPECT_FALSE(proposal.radius);
  EXPECT_TRUE(proposal.problem.starts_with("nothing of the shape lies where r < \"outer\"")) << proposal.problem;
}

TEST(ProposeLimitCylinder, SaysThatAPointCloudHasNoParts) {
  const CylinderProposal proposal = propose_limit_cylinder(about(hand_fingers()[0]), hand().positions, {});
  EXPECT_FALSE(proposal.radius);
  EXPECT_TRUE(proposal.problem.starts_with("without triangles")) << proposal.problem;
}

// An axis that leans over to the next finger.
TEST(ProposeLimitCylinder, SaysWhatIsInTheWayAndWhatToDo) {
  const Finger& ring = hand_fingers()[3];
  BendStroke stroke = bend_of(ring, 30);
  stroke.normal = -normalized(ring.axis + Vec3d{0.5, 0, 0});
  stroke.axis = any_orthogonal(stroke.normal);
  std::vector<std::string> remarks;
  try {
    with_found_radius(stroke, hand().positions, hand().triangles, remarks);
    ADD_FAILURE() << "a radius was found";
  } catch (const InvalidInput& error) {
    const std::string text = error.what();
    EXPECT_TRUE(
        text.starts_with("\"radius\": \"auto\" finds none: where r < \"outer\" the part at \"center\" reaches "))
        << text;
    EXPECT_NE(text.find("of another part come nearer, down to"), std::string::npos) << text;
    EXPECT_NE(text.find("\"center\""), std::string::npos) << text;
  }
}

// Where the message says to move the centre, that works.
TEST(ProposeLimitCylinder, ToldToMoveTheCentreThatHelps) {
  int told = 0;
  for (const Finger& finger : hand_fingers()) {
    for (const double lean : {-0.5, -0.35, -0.2, 0.2, 0.35, 0.5}) {
      const Vec3d axis = normalized(finger.axis + Vec3d{lean, 0, 0});
      StrokeCylinder limit_cylinder{finger.base, -axis, 0, 0, -axis};
      const CylinderProposal proposal = propose_limit_cylinder(limit_cylinder, hand().positions, hand().triangles);
      const std::string key = "move \"center\" by ";
      const std::size_t at = proposal.problem.find(key);
      EXPECT_EQ(proposal.radius.has_value(), proposal.problem.empty());
      if (at == std::string::npos) continue;
      ++told;
      // Three digits of the shift are given, which is 1/24 of the length or more.
      limit_cylinder.center += axis * (std::stod(proposal.problem.substr(at + key.size())) * 1.005);
      EXPECT_TRUE(propose_limit_cylinder(limit_cylinder, hand().positions, hand().triangles).radius)
          << finger.name << " " << lean;
    }
  }
  EXPECT_GT(told, 3);
}

}  // namespace
}  // namespace knead::placement_test
