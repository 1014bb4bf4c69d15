// Parts of a pose: drawn round, painted, moved by the gizmo or about their joint, kept from drag to drag.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "gestures/gesture.h"
#include "gestures/gesture_kinds.h"
#include "gestures/gestures_fixture.h"
#include "view/overlay.h"

namespace knead::studio::parts_test {
namespace {

class PartsTest : public GesturesTest {
 protected:
  // A bar along x from -3 to 3, 1 thick, seen from the front, 1 unit 100 pixels, the middle at (400, 300).
  static std::string bar() {
    return R"({"size": [800, 600]}
{"new": "box", "vertices": 1500}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 6}}
{"tool": "pose"}
{"set": {"pose": "lasso", "detail": 0.1, "radius": 1}}
)";
  }

  // Its left end, then its right end: the part below 1.4 units from the ends.
  static std::string two_parts() {
    return bar() + R"({"drag": [[60, 200], [240, 200], [240, 400], [60, 400], [60, 210]], "steps": 4}
{"drag": [[560, 200], [740, 200], [740, 400], [560, 400], [560, 210]], "steps": 4}
{"set": {"pose": "pins"}}
)";
  }

  static PoseStroke last_pose(const Studio& studio) { return std::get<PoseStroke>(last_strokes(studio).front()); }
  static std::optional<std::size_t> part_of(const PartMarks& marks, std::uint32_t v) {
    return studio::part_of(marks, v);
  }
  static const PosePart& part_of(const PoseStroke& stroke, std::size_t i) {
    return std::get<PosePart>(stroke.parts.at(i));
  }
  static const PartMarks& parts(const Studio& studio) { return studio.tools().placed().parts; }

  // How far the vertices of a part are from where the motion takes them, at most.
  static double distance_from(const Studio& studio, std::size_t part, const std::vector<Vec3d>& before,
                              const RigidMotion& motion) {
    double most = 0;
    const std::vector<Vec3d> now = positions(studio);
    for (const std::uint32_t v : vertices_of(parts(studio), part)) {
      most = std::max(most, norm(now[v] - motion(before[v])));
    }
    return most;
  }
};

TEST_F(PartsTest, ALassoDoesNotTakeWhatIsHiddenBehindOthers) {
  Studio studio(options());
  run(studio, R"({"size": [800, 600]}
{"new": "torus", "vertices": 4000}
{"view": {"yaw_deg": 0, "pitch_deg": 90, "target": [0, 0, 0], "height": 4}}
{"tool": "pose"}
{"set": {"pose": "lasso"}}
{"drag": [[370, 200], [430, 200], [430, 400], [370, 400], [370, 210]], "steps": 4}
)");
  ASSERT_EQ(parts(studio).holds.size(), 1u);
  const std::vector<Vec3d> now = positions(studio);
  const std::vector<std::uint32_t> part = vertices_of(parts(studio), 0);
  const auto behind = [&](std::uint32_t v) { return now[v].y < 0; };
  EXPECT_TRUE(std::none_of(part.begin(), part.end(), behind));
  EXPECT_TRUE(std::any_of(now.begin(), now.end(), [](const Vec3d& p) { return std::abs(p.x) < 0.05 && p.y < 0; }));
}

TEST_F(PartsTest, ALassoMakesAPartThatHoldsAndIsSelected) {
  Studio studio(options());
  run(studio, two_parts());
  EXPECT_EQ(errors(studio), "");
  EXPECT_TRUE(studio.document().shown().history.empty());
  ASSERT_EQ(parts(studio).holds, (std::vector<bool>{true, true}));
  EXPECT_EQ(parts(studio).selected, 1u);
  const std::vector<Vec3d> shape = positions(studio);
  for (std::uint32_t v = 0; v < shape.size(); ++v) {
    if (std::abs(std::abs(shape[v].x) - 1.6) < 0.1) continue;  // at the line
    const std::uint8_t expected = shape[v].x < -1.6 ? 1 : shape[v].x > 1.6 ? 2 : 0;
    EXPECT_EQ(parts(studio).of_vertex[v], expected) << shape[v].x;
  }
  ASSERT_TRUE(parts(studio).placement);
  const Placement& joint = *parts(studio).placement;
  EXPECT_LT(norm(joint.center - Vec3d{1.7, 0, 0}), 0.15) << "in the middle of its border";
  EXPECT_GT(joint.z.x, 0.99) << "towards its end";
  run(studio, R"({"set": {"pose": "lasso"}}
{"click": [-2.5, 0, 0.5]})");
  EXPECT_EQ(parts(studio).selected, 0u) << "a click selects the part there";
  run(studio, R"({"key": "Escape"})");
  EXPECT_FALSE(parts(studio).selected);
  EXPECT_EQ(parts(studio).holds.size(), 2u) << "Escape removes no part";
}

TEST_F(PartsTest, InTheModeLassoADragOnTheSelectedPartTurnsItAndMarksNothing) {
  Studio studio(options());
  run(studio, two_parts() + R"({"set": {"pose": "lasso"}}
{"drag": [[2.8, 0, 0.5], [2.6, 0.6, 0.5]], "steps": 2})");
  EXPECT_EQ(parts(studio).holds.size(), 2u);
  ASSERT_EQ(studio.document().shown().history.size(), 1u);
  EXPECT_TRUE(part_of(last_pose(studio), 0).rotation);
  run(studio, R"({"click": [-2.5, 0, 0.5]})");
  EXPECT_EQ(parts(studio).selected, 0u) << "a click on another one selects it";
}

TEST_F(PartsTest, ADragOfAPartTurnsItAboutItsJointWhileTheOtherHolds) {
  Studio studio(options());
  run(studio, two_parts());
  const std::vector<Vec3d> before = positions(studio);
  const PartMarks marked = parts(studio);
  run(studio, R"({"drag": [[2.8, 0, 0.5], [2.6, 0.6, 0.5]], "steps": 2})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(last_strokes(studio).size(), 1u);
  const PoseStroke stroke = last_pose(studio);
  EXPECT_EQ(stroke.detail, 0.1);
  ASSERT_EQ(stroke.parts.size(), 2u);
  ASSERT_TRUE(part_of(stroke, 0).rotation);
  const HandlesRotation turn = *part_of(stroke, 0).rotation;
  EXPECT_EQ(turn.center, marked.placement->center);
  const double expected = std::atan2(0.6, 2.6 - turn.center.x) * 180 / std::numbers::pi;
  EXPECT_NEAR(turn.angle_deg, expected, 3);
  EXPECT_TRUE(part_of(stroke, 1).hold);
  std::size_t named = 0;
  for (const VertexRange& range : part_of(stroke, 1).vertices) named += range.last - range.first + 1;
  EXPECT_EQ(named, vertices_of(marked, 0).size());
  const double slack = 6e-3 * studio.document().shown().diagonal;
  const RigidMotion motion = rotation_about(turn.center, turn.axis, turn.angle_deg * std::numbers::pi / 180);
  EXPECT_LT(distance_from(studio, 1, before, motion), slack);
  EXPECT_LT(distance_from(studio, 0, before, RigidMotion{}), slack);
  EXPECT_EQ(parts(studio).of_vertex, marked.of_vertex);
  EXPECT_GT(parts(studio).placement->z.y, 0.2) << "the gizmo goes with the part";
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_LT(norm(parts(studio).placement->center - marked.placement->center), 1e-12);
}

TEST_F(PartsTest, AStiffPartStaysAsItIsWhereAnotherBends) {
  std::array<double, 2> stretch{};
  for (const double stiffness : {1.0, 100.0}) {
    Studio studio(options());
    run(studio, two_parts() + R"({"set": {"pose": "lasso"}}
{"drag": [[350, 200], [400, 200], [400, 400], [350, 400], [350, 210]], "steps": 4}
{"set": {"pose": "pins"}})");
    const std::vector<Vec3d> before = positions(studio);
    ASSERT_EQ(parts(studio).stiffness.size(), 3u);
    studio.tools().placed().parts.holds[2] = false;
    studio.tools().placed().parts.stiffness[2] = stiffness;
    const std::vector<std::uint32_t> middle = vertices_of(parts(studio), 2);
    run(studio, R"({"drag": [[2.8, 0, 0.5], [2.5, 1, 0.5]], "steps": 2})");
    EXPECT_EQ(errors(studio), "");
    const std::vector<PoseStiffness> regions = last_pose(studio).stiffness;
    EXPECT_EQ(regions.size(), stiffness == 1 ? 0u : 1u);
    std::size_t named = 0;
    for (const PoseStiffness& region : regions) {
      EXPECT_EQ(region.value, stiffness);
      for (const VertexRange& range : region.vertices) named += range.last - range.first + 1;
    }
    EXPECT_EQ(named, stiffness == 1 ? 0 : middle.size());
    double& most = stretch.at(stiffness == 1 ? 0 : 1);
    most = 0;
    const std::vector<Vec3d> now = positions(studio);
    for (const std::uint32_t v : middle) {
      const double length = norm(before[v] - before[middle.front()]);
      if (length > 0) most = std::max(most, std::abs(norm(now[v] - now[middle.front()]) / length - 1));
    }
  }
  EXPECT_LT(stretch[1], 0.6 * stretch[0]);
}

TEST_F(PartsTest, AnArrowMovesAPartByATypedLengthAndARingTurnsItByATypedAngle) {
  Studio studio(options());
  run(studio, two_parts());
  const Placement start = *parts(studio).placement;
  const auto at = [&](const Vec3d& p) {
    const auto pixel = pixel_of(studio.view().screen(), p);
    return fmt::format("[{}, {}]", pixel->x, pixel->y);
  };
  const Vec3d on_arrow = start.center + start.z * (0.9 * gizmo_size(studio.view().screen(), start));
  run(studio, fmt::format(R"({{"press": {}}}
{{"move": [650, 300]}}
{{"key": "."}}
{{"key": "2"}}
{{"key": "Enter"}})",
                          at(on_arrow)));
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1u);
  const PosePart moved = part_of(last_pose(studio), 0);
  EXPECT_FALSE(moved.rotation);
  ASSERT_TRUE(moved.translation);
  EXPECT_LT(norm(*moved.translation - start.z * 0.2), 1e-12);
}

TEST_F(PartsTest, TheBrushPaintsCtrlFreesAndAltRemoves) {
  Studio studio(options());
  run(studio, bar() + R"({"set": {"pose": "brush"}}
{"drag": [[2.8, 0, 0.5], [2.2, 0, 0.5]]}
)");
  ASSERT_EQ(parts(studio).holds.size(), 1u);
  const std::size_t painted = vertices_of(parts(studio), 0).size();
  EXPECT_GT(painted, 10u);
  for (const std::uint32_t v : vertices_of(parts(studio), 0)) EXPECT_GT(positions(studio)[v].x, 1.6);
  run(studio, R"({"click": [2.8, 0, 0.5], "modifiers": ["ctrl"]})");
  EXPECT_LT(vertices_of(parts(studio), 0).size(), painted);
  run(studio, R"({"key": "Escape"}
{"click": [-2.5, 0, 0.5]})");
  EXPECT_EQ(parts(studio).holds.size(), 2u) << "nothing was selected: a new one";
  run(studio, R"({"set": {"pose": "pins"}}
{"key": "Escape"}
{"click": [-2.5, 0, 0.5]})");
  EXPECT_EQ(parts(studio).selected, 1u);
  EXPECT_TRUE(studio.tools().placed().pins.empty()) << "no pin where a part is";
  run(studio, R"({"click": [2.2, 0, 0.5], "modifiers": ["alt"]})");
  EXPECT_EQ(parts(studio).holds.size(), 1u);
  EXPECT_TRUE(studio.document().shown().history.empty());
}

TEST_F(PartsTest, PartsAndPinsAreOfOnePose) {
  Studio studio(options());
  run(studio, two_parts() + R"({"click": [0, 0, 0.5]}
{"key": "Escape"}
{"drag": [[0, 0, 0.5], [0, 0.4, 0.5]], "steps": 2}
)");
  EXPECT_EQ(errors(studio), "");
  const PoseStroke stroke = last_pose(studio);
  ASSERT_EQ(stroke.parts.size(), 3u);
  EXPECT_FALSE(std::get<PosePin>(stroke.parts[0]).hold);
  EXPECT_TRUE(part_of(stroke, 1).hold);
  EXPECT_TRUE(part_of(stroke, 2).hold);
}

TEST_F(PartsTest, AMirroredPartMovesTheOneOnTheOtherSide) {
  Studio studio(options());
  run(studio, two_parts() + R"({"set": {"mirror": [true, false, false]}}
{"drag": [[2.8, 0, 0.5], [2.7, 0.4, 0.5]], "steps": 2}
)");
  EXPECT_EQ(errors(studio), "");
  const PoseStroke stroke = last_pose(studio);
  ASSERT_EQ(stroke.parts.size(), 2u) << "the part that is marked there does not hold";
  ASSERT_TRUE(part_of(stroke, 1).rotation);
  EXPECT_EQ(part_of(stroke, 1).rotation->angle_deg * part_of(stroke, 1).rotation->axis.z,
            -part_of(stroke, 0).rotation->angle_deg * part_of(stroke, 0).rotation->axis.z);
  const std::vector<Vec3d> now = positions(studio);
  double left = 0, right = 0;
  for (const Vec3d& p : now) (p.x < 0 ? left : right) = std::max(p.x < 0 ? left : right, p.y);
  EXPECT_NEAR(left, right, 0.03);
  EXPECT_GT(right, 0.8);
}

TEST_F(PartsTest, RemeshingAndUndoTakeThePartsAlong) {
  Studio studio(options());
  run(studio, two_parts());
  const std::vector<std::uint8_t> before = parts(studio).of_vertex;
  run(studio, R"({"set": {"remesh": true, "max_edge": 0.15}}
{"drag": [[2.8, 0, 0.5], [2.8, 0.3, 0.5]], "steps": 1})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_NE(parts(studio).of_vertex.size(), before.size());
  ASSERT_EQ(parts(studio).of_vertex.size(), positions(studio).size());
  const std::vector<Vec3d> now = positions(studio);
  for (std::uint32_t v = 0; v < now.size(); ++v) {
    const bool is_between = std::abs(now[v].x) < 1.3;
    if (is_between || now[v].x > 2) {
      EXPECT_EQ(parts(studio).of_vertex[v], is_between ? 0 : 2) << now[v].x;
    }
  }
  run(studio, R"({"drag": [[2.7, 0.3, 0.5], [2.7, 0.5, 0.5]], "steps": 1})");
  EXPECT_EQ(part_of(last_pose(studio), 0).vertices.empty(), studio.document().shown().state.provenance->is_renumbered);
  run(studio, R"({"key": "Ctrl+Z"}
{"key": "Ctrl+Z"})");
  EXPECT_EQ(parts(studio).of_vertex, before);
}

TEST_F(PartsTest, PartsAreColouredUnlessTheStretchIs) {
  Studio studio(options());
  run(studio, two_parts());
  Overlay overlay;
  const auto shades = overlay.influence(studio);
  ASSERT_TRUE(shades);
  for (std::size_t v = 0; v < shades->size(); ++v) {
    EXPECT_EQ((*shades)[v] > 0, parts(studio).of_vertex[v] != 0);
    EXPECT_EQ((*shades)[v] == 1, parts(studio).of_vertex[v] == 2) << "the selected one";
  }
  EXPECT_FALSE(overlay.influence(studio)) << "nothing has changed";
  EXPECT_TRUE(overlay.scene(studio).show_influence);
  run(studio, R"({"show": {"stretch": "since_start"}})");
  EXPECT_TRUE(overlay.scene(studio).show_stretch);
  EXPECT_FALSE(overlay.scene(studio).show_influence);
}

// A hand seen from the palm: 1 unit 200 pixels, the middle at (400, 300).
constexpr const char* kHand = R"({"size": [800, 600]}
{"new": "hand", "vertices": 4000}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"tool": "pose"}
{"set": {"pose": "pins", "detail": 0.1}}
)";

TEST_F(PartsTest, ADoubleClickOnAFingerMakesItAPartAndHoldsTheRest) {
  Studio studio(options());
  run(studio, std::string(kHand) + R"({"double_click": [0.11, 0.6, 0.09]})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_TRUE(studio.tools().placed().pins.empty()) << "the first click's pin is gone";
  ASSERT_EQ(parts(studio).holds.size(), 2u);
  EXPECT_EQ(parts(studio).selected, 1u);
  EXPECT_GT(parts(studio).placement->z.y, 0.9) << "the middle finger goes up";
  const std::vector<Vec3d> shape = positions(studio);
  for (std::uint32_t v = 0; v < shape.size(); ++v) {
    if (shape[v].y < -0.5) {
      EXPECT_EQ(part_of(parts(studio), v), 0u) << "the wrist holds";
    }
  }
  // The next finger finds the body marked; what bends at its joint is freed.
  run(studio, R"({"double_click": [-0.13, 0.5, 0.08]})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(parts(studio).holds, (std::vector<bool>{true, true, true}));
  EXPECT_TRUE(studio.document().shown().history.empty());
}

// Where vertices are rare, that pin is farther from the pointer than a pin is met.
TEST_F(PartsTest, ADoubleClickLeavesNoPinOnACoarseShape) {
  for (const double y : {0.2, 0.27, 0.35, 0.47, 0.55, 0.62, 0.7}) {
    Studio studio(options());
    run(studio, fmt::format(R"({{"size": [1600, 1200]}}
{{"new": "hand", "vertices": 4000}}
{{"view": {{"yaw_deg": 0, "pitch_deg": 0, "target": [0.1, 0.4, 0], "height": 0.7}}}}
{{"tool": "pose"}}
{{"double_click": [0.11, {}, 0.09]}})",
                            y));
    EXPECT_TRUE(studio.tools().placed().pins.empty()) << y;
    EXPECT_EQ(parts(studio).holds.size(), 2u) << y;
    EXPECT_EQ(errors(studio), "") << y;
  }
}

// A finger that is dragged through the one beside it.
TEST_F(PartsTest, WhatIsShownDuringADragIsNotTorn) {
  Studio studio(options());
  run(studio, std::string(kHand) + R"({"double_click": [-0.15, 0.5, 0.08]}
{"press": [-0.17, 0.65, 0.08]})");
  ASSERT_TRUE(studio.gesture());
  const std::vector<Vec3d> start = positions(studio);
  const std::vector<Triangle> triangles = triangulate(*studio.document().shown().state.mesh);
  double most = 1;
  for (int i = 1; i <= 4; ++i) {
    run(studio, fmt::format(R"({{"move": [{}, {}, 0.08]}})", -0.17 + 0.18 * i, 0.65 - 0.06 * i));
    const double stretch = surface_stretch(triangles, start, positions(studio)).worst();
    EXPECT_LT(stretch, 10) << i;
    most = std::max(most, stretch);
  }
  EXPECT_GT(most, 1.2) << "it has been moved";
}

// Bend finds no part at the last joint of a finger; a pose turns what is beyond it.
TEST_F(PartsTest, WhatIsBeyondAPlacedBendBecomesAPart) {
  for (const bool is_upside_down : {false, true}) {
    Studio studio(options());
    run(studio, std::string(kHand) + R"({"tool": "bend"}
{"click": [0.11, 0.75, 0.09]})");
    ASSERT_TRUE(studio.tools().placed().placement);
    Placement joint{{0.11, 0.75, 0.02}};
    joint.z = {0, is_upside_down ? -1.0 : 1.0, 0};
    studio.tools().placed().placement = joint;
    studio.pose_placed();
    EXPECT_EQ(studio.tools().settings().tool->use, ToolUse::pose);
    ASSERT_EQ(parts(studio).holds.size(), 2u);
    EXPECT_EQ(parts(studio).selected, 1u);
    const std::vector<Vec3d> shape = positions(studio);
    for (std::uint32_t v = 0; v < shape.size(); ++v) {
      const bool is_tip = shape[v].y > 0.75 && std::abs(shape[v].x - 0.11) < 0.12;
      EXPECT_EQ(part_of(parts(studio), v), is_tip ? 1u : 0u) << shape[v].x << ' ' << shape[v].y;
    }
    EXPECT_LT(norm(parts(studio).placement->center - Vec3d{0.11, 0.75, 0.02}), 0.1) << "the gizmo is at the joint";
  }
  Studio studio(options());
  run(studio, R"({"new": "torus", "vertices": 4000}
{"tool": "bend"})");
  Placement joint{{1, 0, 0}};
  joint.z = {0, 1, 0};
  studio.tools().placed().placement = joint;
  studio.pose_placed();
  EXPECT_TRUE(parts(studio).holds.empty()) << "a ring is not divided at one place";
  EXPECT_EQ(studio.tools().settings().pose, PoseMode::lasso);
}

TEST_F(PartsTest, ADoubleClickAndADragTurnTheFingerAboutItsKnuckle) {
  Studio studio(options());
  run(studio, std::string(kHand) + R"({"view": {"yaw_deg": 70}}
{"set": {"detail": 0.075}}
{"click": [0.44, 0.6, 0.02]}
)");
  const std::vector<Vec3d> before = positions(studio);
  const auto pixel = pixel_of(studio.view().screen(), {0.44, 0.6, 0.02});
  EXPECT_EQ(studio.tools().placed().pins.size(), 1u);
  studio.handle(ButtonChanged{MouseButton::left, true, pixel->x, pixel->y, {}, true});
  ASSERT_TRUE(studio.gesture());
  studio.handle(PointerMoved{pixel->x - 30, pixel->y + 8, 1, {}});
  studio.handle(ButtonChanged{MouseButton::left, false, pixel->x - 30, pixel->y + 8, {}});
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1u);
  const PoseStroke stroke = last_pose(studio);
  ASSERT_EQ(stroke.parts.size(), 2u);
  ASSERT_TRUE(part_of(stroke, 0).rotation);
  EXPECT_GT(part_of(stroke, 0).rotation->angle_deg, 5);
  const double slack = 5e-3 * studio.document().shown().diagonal;
  const std::vector<Vec3d> now = positions(studio);
  for (std::size_t v = 0; v < now.size(); ++v) {
    if (before[v].y < -0.5) {
      EXPECT_LT(norm(now[v] - before[v]), slack) << "the wrist holds";
    }
  }
  const HandlesRotation& turn = *part_of(stroke, 0).rotation;
  const RigidMotion motion = rotation_about(turn.center, turn.axis, turn.angle_deg * std::numbers::pi / 180);
  EXPECT_LT(distance_from(studio, 1, before, motion), slack);
}

}  // namespace
}  // namespace knead::studio::parts_test
