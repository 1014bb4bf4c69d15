// Poses of skins: rigid bones, kept volume, correctives, and the blends they are compared with.
#include "knead/fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "skin/joints.h"
#include "support/unwelded.h"

namespace knead::skin_test {
namespace {

// A bar along x whose halves hang on two bones; the flesh between x = -width and width is blended.
struct Arm {
  Mesh mesh = make_shape(ShapeKind::box, 2000);
  Skin skin;

  explicit Arm(double width = 0.6) {
    skin.rest = {{{}, {-3, 0, 0}}, {{}, {0, 0, 0}}};
    skin.parents = {-1, 0};
    skin.begin = {0};
    for (const Vec3d& p : mesh.positions) {
      const double w = std::clamp(0.5 + 0.5 * p.x / width, 0.0, 1.0);
      if (w < 1) skin.weights.push_back({0, 1 - w});
      if (w > 0) skin.weights.push_back({1, w});
      skin.begin.push_back(skin.weights.size());
    }
  }

  // The second bone turned about z.
  SkinPose bent(double degrees) const {
    const SinCos<double> turn = sincos(degrees * std::numbers::pi / 180);
    SkinPose pose = skin.rest;
    pose[1].linear = {{turn.cos, -turn.sin, 0}, {turn.sin, turn.cos, 0}, {0, 0, 1}};
    return pose;
  }
};

std::string complaint(const auto& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Skin, KeepsVolumeWhereLinearBlendLosesIt) {
  const Arm arm;
  const SkinResult result = pose_skin(arm.mesh, arm.skin, arm.bent(90));
  const SkinReport& report = result.report;
  EXPECT_LT(*report.linear.volume_error, -5e-3);
  EXPECT_LT(std::abs(*report.flow.volume_error), 2e-5);  // what triangles lose is given back, to second order
  EXPECT_EQ(report.flow.crossings_new, 0u);
  EXPECT_GT(report.flow.least_stretch, 0.3);
  EXPECT_LT(report.part_distance_95, 0.03);  // beside the joint the flesh bends on more than is blended
  EXPECT_EQ(report.bones, 1u);
}

// Bones that end a chain, and a chain of them, move nothing: the pose is that of the other bones.
TEST(Skin, BonesOnWhichNothingHangsMoveNothing) {
  Arm arm;
  const std::vector<BoneTurn> bent{{1, {0, 0, 1}, 40}};
  const SkinResult without = pose_skin(arm.mesh, arm.skin, turned_pose(arm.skin, bent), {}, false);
  for (const double x : {3.0, 3.5}) arm.skin.rest.push_back({{}, {x, 0, 0}});
  arm.skin.parents = {-1, 0, 1, 2};
  const auto turned = [&](std::vector<BoneTurn> turns) {
    return pose_skin(arm.mesh, arm.skin, turned_pose(arm.skin, turns), {}, false);
  };
  const SkinResult leaf = turned({{2, {0, 0, 1}, 60}, {3, {0, 1, 0}, 30}});
  EXPECT_EQ(leaf.positions, arm.mesh.positions);
  EXPECT_EQ(leaf.report.bones, 0U);
  const SkinResult both = turned({{1, {0, 0, 1}, 40}, {3, {0, 0, 1}, 60}});
  EXPECT_EQ(both.positions, without.positions);
  EXPECT_EQ(both.report.bones, 1U);
  arm.skin.weights.push_back({3, 0});  // a weight of 0 is none
  arm.skin.begin.back() = arm.skin.weights.size();
  EXPECT_EQ(turned({{3, {0, 0, 1}, 60}}).positions, arm.mesh.positions);
  const SkinPose pose = turned_pose(arm.skin, std::vector<BoneTurn>{{1, {0, 0, 1}, 40}, {2, {0, 0, 1}, 60}});
  const std::vector<Corrective> correctives = make_correctives(arm.mesh, arm.skin, pose);
  ASSERT_EQ(correctives.size(), 1U);
  EXPECT_EQ(correctives[0].bones, std::vector<std::uint32_t>{1});
}

// A seam of normals or texture coordinates gives places several vertices.
TEST(Skin, UnweldedShapesArePosedAsWeldedOnes) {
  const Arm arm;
  const Mesh soup = test::unwelded(arm.mesh);
  Skin skin = arm.skin;
  skin.weights.clear();
  skin.begin = {0};
  for (const std::uint32_t v : arm.mesh.corner_vertex) {
    for (std::size_t i = arm.skin.begin[v]; i < arm.skin.begin[v + 1]; ++i) skin.weights.push_back(arm.skin.weights[i]);
    skin.begin.push_back(skin.weights.size());
  }
  const SkinResult expected = pose_skin(arm.mesh, arm.skin, arm.bent(60));
  const SkinResult result = pose_skin(soup, skin, arm.bent(60));
  ASSERT_TRUE(result.report.flow.volume_error);
  EXPECT_NEAR(*result.report.flow.volume_error, *expected.report.flow.volume_error, 1e-5);
  EXPECT_EQ(result.report.segments, expected.report.segments);
  EXPECT_LT(test::farthest_apart(arm.mesh, expected.positions, result.positions), 2e-3);
}

// A body that only flows is strained ever more where the first steps did: stretched by 3.2 here, by 0.268 in the mean.
TEST(Skin, TheFleshOfAJointSharesTheStrain) {
  const Arm arm;
  const SkinReport report = pose_skin(arm.mesh, arm.skin, arm.bent(120), {}, false).report;
  EXPECT_EQ(report.flow.crossings_new, 0U);
  EXPECT_GT(report.flow.least_stretch, 0.275);
  EXPECT_LT(report.flow.greatest_stretch, 2.7);
  EXPECT_LT(report.flow.rms_log_stretch, 0.25);
}

// Clothes may be open: the volume of the body within them stays.
TEST(Skin, AnOpenSleeveLeavesTheVolumeOfTheArm) {
  const Arm arm;
  const double before = measure(arm.mesh).volume;
  Mesh sleeve;
  sleeve.positions = arm.mesh.positions;
  for (Vec3d& p : sleeve.positions) p = {p.x, 1.1 * p.y, 1.1 * p.z};
  for (std::size_t f = 0; f < arm.mesh.face_count(); ++f) {
    const auto face = arm.mesh.face(f);
    const auto is_inner = [&](std::uint32_t v) { return std::abs(arm.mesh.positions[v].x) < 2; };
    if (!std::all_of(face.begin(), face.end(), is_inner)) continue;
    sleeve.corner_vertex.insert(sleeve.corner_vertex.end(), face.begin(), face.end());
    sleeve.face_begin.push_back(static_cast<std::uint32_t>(sleeve.corner_vertex.size()));
  }
  ASSERT_GT(sleeve.face_count(), 100U);
  const std::vector<const Mesh*> meshes{&arm.mesh, &sleeve};
  const JoinedMeshes both(meshes);
  Skin skin = arm.skin;
  skin.weights.insert(skin.weights.end(), arm.skin.weights.begin(), arm.skin.weights.end());
  for (std::size_t v = 1; v < arm.skin.begin.size(); ++v) {
    skin.begin.push_back(arm.skin.begin.back() + arm.skin.begin[v]);
  }
  const SkinResult result = pose_skin(both.mesh(), skin, arm.bent(70), {}, false);
  EXPECT_FALSE(result.report.flow.volume_error) << "the whole is open";
  Mesh posed = arm.mesh;
  posed.positions.assign(result.positions.begin(),
                         result.positions.begin() + static_cast<std::ptrdiff_t>(posed.vertex_count()));
  EXPECT_LT(std::abs(measure(posed).volume / before - 1), 2e-5);
  EXPECT_EQ(result.report.flow.crossings_new, 0U);
}

// An arm with two joints, at x = -1.5 and 1.5, whose half-thickness is 0.7 - taper * x.
Arm tapered_arm(double taper) {
  Arm arm;
  for (Vec3d& p : arm.mesh.positions) {
    const double thickness = 0.7 - taper * p.x;
    p = {p.x, thickness * p.y, thickness * p.z};
  }
  arm.skin.rest = {{{}, {-3, 0, 0}}, {{}, {-1.5, 0, 0}}, {{}, {1.5, 0, 0}}};
  arm.skin.parents = {-1, 0, 1};
  arm.skin.begin = {0};
  arm.skin.weights.clear();
  for (const Vec3d& p : arm.mesh.positions) {
    const double first = std::clamp(0.5 + 0.5 * (p.x + 1.5) / 0.4, 0.0, 1.0);
    const double second = std::clamp(0.5 + 0.5 * (p.x - 1.5) / 0.4, 0.0, 1.0);
    arm.skin.weights.push_back({0, 1 - first});
    arm.skin.weights.push_back({1, first - second});
    arm.skin.weights.push_back({2, second});
    arm.skin.begin.push_back(arm.skin.weights.size());
  }
  return arm;
}

// Joints of one limb, of which one is 2.5 times as thick, turn together.
TEST(Skin, JointsOfSimilarSizeTurnTogether) {
  const Arm arm = tapered_arm(0.2);
  const std::vector<BoneTurn> turns{{1, {0, 0, 1}, 10}, {2, {0, 0, 1}, 10}};
  const SkinResult result = pose_skin(arm.mesh, arm.skin, turned_pose(arm.skin, turns), {}, false);
  EXPECT_EQ(result.report.bones, 2U);
  EXPECT_EQ(result.report.stages, 1U);
}

// In each stage the flesh at the joint that turns in the other one belongs to one rigid body.
TEST(Skin, FleshIsFreeOnlyWhereTheStageTurns) {
  const Arm arm = tapered_arm(0.27);
  const std::vector<BoneTurn> turns{{1, {0, 0, 1}, 10}, {2, {0, 0, 1}, 10}};
  const detail::Joints joints =
      detail::find_joints(arm.mesh.positions, triangulate(arm.mesh), arm.skin, turned_pose(arm.skin, turns), 0);
  ASSERT_EQ(joints.stages, 2U);
  constexpr double kRigid = 0.9;
  for (std::size_t v = 0; v < arm.mesh.vertex_count(); ++v) {
    const double x = arm.mesh.positions[v].x;
    const auto body = [&](std::size_t stage) { return joints.rigid_body(joints.bodies(stage), v, kRigid); };
    if (x < 1) {
      EXPECT_EQ(body(0), 0U) << x;
    }
    if (x > -1) {
      EXPECT_EQ(body(1), 1U) << x;
    }
    if (std::abs(x - 1.5) < 0.1) {
      EXPECT_FALSE(body(0)) << x;
    }
    if (std::abs(x + 1.5) < 0.1) {
      EXPECT_FALSE(body(1)) << x;
    }
  }
}

// The halves of an arm that bends back onto itself meet: the pose is sound, and says that it fell short.
TEST(Skin, APoseThatCannotBeComesAsFarAsItIsSound) {
  const Arm arm;
  const SkinReport report = pose_skin(arm.mesh, arm.skin, arm.bent(179), {}, false).report;
  EXPECT_EQ(report.flow.crossings_new, 0U);
  EXPECT_LE(std::max(report.flow.greatest_stretch, 1 / report.flow.least_stretch), kMaxPosedStretch);
  EXPECT_FALSE(report.shortfall.empty());
  EXPECT_NE(complaint_about(report).find(report.shortfall), std::string::npos);
}

TEST(Skin, AtRestNothingMoves) {
  const Arm arm;
  const SkinResult result = pose_skin(arm.mesh, arm.skin, arm.skin.rest);
  EXPECT_TRUE(result.strokes.empty());
  EXPECT_EQ(result.positions, arm.mesh.positions);
}

// What moves as a whole keeps all distances.
TEST(Skin, AWholeSkeletonMovesRigidly) {
  const Arm arm;
  SkinPose pose = arm.bent(0);
  const Mat3d turn{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  for (BoneTransform& bone : pose) bone = {turn * bone.linear, turn * bone.offset + Vec3d{1, 2, 3}};
  const SkinResult result = pose_skin(arm.mesh, arm.skin, pose);
  double worst = 0;
  for (std::size_t v = 0; v < arm.mesh.positions.size(); ++v) {
    worst = std::max(worst, norm(result.positions[v] - (turn * arm.mesh.positions[v] + Vec3d{1, 2, 3})));
  }
  EXPECT_LT(worst, 1e-4 * shape_box(arm.mesh).diagonal());  // ten times the tolerance of the path lines
}

// By 179 degrees the stage falls short twice, and only one of its ways counts.
TEST(Skin, StrokesRepeatThePose) {
  const Arm arm;
  for (const double degrees : {60.0, 179.0}) {
    const SkinResult result = pose_skin(arm.mesh, arm.skin, arm.bent(degrees), {}, false);
    Session session;
    for (const Stroke& stroke : result.strokes) session.strokes.push_back({stroke});
    const ReplayResult replayed = replay(arm.mesh, session, ReplayOptions{});
    EXPECT_EQ(replayed.shape.positions(), result.positions) << degrees;
  }
}

TEST(Skin, TheSameBitsForEveryNumberOfThreads) {
  const Arm arm;
  SkinOptions options;
  options.threads = 1;
  const SkinResult one = pose_skin(arm.mesh, arm.skin, arm.bent(40), options, false);
  options.threads = 2;
  EXPECT_EQ(pose_skin(arm.mesh, arm.skin, arm.bent(40), options, false).positions, one.positions);
}

// Without parents, bones that share vertices hang together.
TEST(Skin, ParentsAreFound) {
  const Arm arm;
  Skin alone = arm.skin;
  alone.parents.clear();
  EXPECT_EQ(pose_skin(arm.mesh, alone, arm.bent(40), {}, false).positions,
            pose_skin(arm.mesh, arm.skin, arm.bent(40), {}, false).positions);
}

TEST(Skin, RigidVerticesGoWithTheirBoneInEveryBlend) {
  const Arm arm;
  const SkinPose pose = arm.bent(120);
  const std::vector<Vec3d> linear = linear_blend(arm.mesh.positions, arm.skin, pose);
  const std::vector<Vec3d> dual = dual_quaternion_blend(arm.mesh.positions, arm.skin, pose);
  for (std::size_t v = 0; v < linear.size(); ++v) {
    const Vec3d& p = arm.mesh.positions[v];
    if (std::abs(p.x) < 0.6) continue;
    const Vec3d place = p.x < 0 ? p : pose[1].linear * p;
    EXPECT_LT(norm(linear[v] - place), 1e-12);
    EXPECT_LT(norm(dual[v] - place), 1e-12);
  }
}

TEST(Skin, ACorrectiveShapeGivesThePoseBackByLinearBlend) {
  const Arm arm;
  const SkinPose pose = arm.bent(70);
  const SkinResult result = pose_skin(arm.mesh, arm.skin, pose, {}, false);
  const std::vector<Vec3d> rest = corrective_shape(arm.mesh.positions, result.positions, arm.skin, pose);
  const std::vector<Vec3d> back = linear_blend(rest, arm.skin, pose);
  double worst = 0;
  for (std::size_t v = 0; v < back.size(); ++v) worst = std::max(worst, norm(back[v] - result.positions[v]));
  EXPECT_LT(worst, 1e-10);
}

// At the pose that they were made for, linear blend with the correctives gives the flow's shape back.
TEST(Skin, CorrectivesOfTwoJointsAddUp) {
  Arm arm;
  // A third bone from x = 1.5 on.
  arm.skin.rest.push_back({{}, {1.5, 0, 0}});
  arm.skin.parents.push_back(1);
  arm.skin.begin = {0};
  arm.skin.weights.clear();
  for (const Vec3d& p : arm.mesh.positions) {
    const double first = std::clamp(0.5 + 0.5 * p.x / 0.6, 0.0, 1.0);
    const double second = std::clamp(0.5 + 0.5 * (p.x - 1.5) / 0.6, 0.0, 1.0);
    arm.skin.weights.push_back({0, 1 - first});
    arm.skin.weights.push_back({1, first - second});
    arm.skin.weights.push_back({2, second});
    arm.skin.begin.push_back(arm.skin.weights.size());
  }
  const Mat3d turn{{0.5, -std::sqrt(0.75), 0}, {std::sqrt(0.75), 0.5, 0}, {0, 0, 1}};
  SkinPose pose = arm.skin.rest;
  pose[1].linear = turn;
  pose[2] = {turn, turn * Vec3d{1.5, 0, 0}};
  const std::vector<Corrective> only_one = make_correctives(arm.mesh, arm.skin, pose);
  ASSERT_EQ(only_one.size(), 1u);  // the third bone goes along
  pose[2].linear = turn * turn;
  const std::vector<Corrective> both = make_correctives(arm.mesh, arm.skin, pose);
  ASSERT_EQ(both.size(), 3u);
  EXPECT_EQ(both[2].bones.size(), 2u);
  for (const double w : corrective_weights(both, arm.skin, pose)) EXPECT_NEAR(w, 1, 1e-12);
  for (const double w : corrective_weights(both, arm.skin, arm.skin.rest)) EXPECT_EQ(w, 0);
  const std::vector<Vec3d> blend = corrected_blend(arm.mesh.positions, both, arm.skin, pose);
  const SkinResult flow = pose_skin(arm.mesh, arm.skin, pose, {}, false);
  double worst = 0;
  for (std::size_t v = 0; v < blend.size(); ++v) worst = std::max(worst, norm(blend[v] - flow.positions[v]));
  EXPECT_LT(worst, 1e-9);
}

TEST(Skin, WhatDoesNotFitIsNamed) {
  const Arm arm;
  const auto with = [&](const auto& change) {
    Skin skin = arm.skin;
    SkinPose pose = arm.bent(10);
    change(skin, pose);
    return complaint([&] { pose_skin(arm.mesh, skin, pose, {}, false); });
  };
  const auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_TRUE(contains(with([](Skin& s, SkinPose&) { s.parents = {1, 0}; }), "circle"));
  EXPECT_TRUE(contains(with([](Skin& s, SkinPose&) { s.parents = {-1, 7}; }), "parent of bone 1"));
  EXPECT_TRUE(contains(with([](Skin& s, SkinPose&) { s.weights[0].weight = -1; }), "vertex 0"));
  EXPECT_TRUE(contains(with([](Skin& s, SkinPose&) { s.weights[0].bone = 9; }), "bone 9"));
  EXPECT_TRUE(contains(with([](Skin& s, SkinPose&) { s.begin.pop_back(); }), "vertices"));
  EXPECT_TRUE(contains(with([](Skin&, SkinPose& p) { p.pop_back(); }), "pose has 1"));
  EXPECT_TRUE(contains(with([](Skin&, SkinPose& p) { p[1].linear.row0 = {0, 0, 0}; }), "no inverse"));
  EXPECT_TRUE(contains(with([](Skin&, SkinPose& p) { p[1].linear.row0 = -p[1].linear.row0; }), "mirrors"));
  EXPECT_TRUE(contains(with([](Skin&, SkinPose& p) { p[1].offset.x = NAN; }), "not finite"));
}

}  // namespace
}  // namespace knead::skin_test
