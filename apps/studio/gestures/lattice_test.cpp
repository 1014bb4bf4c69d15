// The lattice about the shape: its control points, their selection, one stroke that grows, what is refused, and undo.
#include <fstream>
#include <string>
#include <vector>

#include "gestures/gestures_fixture.h"
#include "knead/editor/tools.h"

namespace knead::studio {
namespace {

constexpr std::size_t kNearCorner = 26;  // at the upper right, nearest to the eye, of 3 by 3 by 3
constexpr double kCorner = 1.04;
constexpr const char* kMoveCorner = R"({"drag": [[1.04, 1.04, 1.04], [1.24, 1.14, 1.04]]}
)";
constexpr const char* kCorners = R"({"set": {"lattice_x": 2, "lattice_y": 2, "lattice_z": 2}}
)";
constexpr const char* kRightFace = R"({"drag": [[0.6, 1.6, 0], [1.6, 1.6, 0], [1.6, -1.6, 0], [0.6, -1.6, 0]]}
)";

class LatticeGestureTest : public GesturesTest {
 protected:
  static std::string with_lattice(const std::string& mode = "volume") {
    return ball() + R"({"set": {"remesh": false}}
{"tool": "lattice"}
{"set": {"lattice_mode": ")" +
           mode + "\"}}\n";
  }

  static const PlacedLattice& placed(const Studio& studio) { return studio.tools().placed().lattice; }
  static std::size_t entries(const Studio& studio) { return studio.document().shown().history.size(); }
  static LatticeStroke last_lattice(const Studio& studio) {
    return std::get<LatticeStroke>(last_strokes(studio).front());
  }

  // What the library makes of the shape as it was opened, and one stroke.
  static std::vector<Vec3d> replayed(const Studio& studio, const Stroke& stroke) {
    const DocumentState& shown = studio.document().shown();
    Mesh mesh = *shown.start.mesh;
    mesh.positions = shown.start.positions.copy();
    Session session;
    session.strokes = {{stroke}};
    const ReplayResult result = replay(mesh, session);
    return {result.shape.positions().begin(), result.shape.positions().end()};
  }

  // The selected control points.
  static std::vector<std::size_t> selected(const Studio& studio) {
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < placed(studio).selected.size(); ++i) {
      if (placed(studio).selected[i]) numbers.push_back(i);
    }
    return numbers;
  }
};

TEST_F(LatticeGestureTest, LiesAboutTheShapeAndADragMovesOneControlPoint) {
  Studio studio(options());
  run(studio, with_lattice());
  const std::vector<Vec3d> points = control_points(placed(studio).stroke);
  ASSERT_EQ(points.size(), 27U);
  EXPECT_LT(norm(points.back() - Vec3d{kCorner, kCorner, kCorner}), 1e-6);
  run(studio, kMoveCorner);
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 1U);
  const LatticeStroke stroke = last_lattice(studio);
  for (std::size_t i = 0; i < 27; ++i) {
    const Vec3d aim = i == kNearCorner ? Vec3d{0.2, 0.1, 0} : Vec3d{0, 0, 0};
    EXPECT_LT(norm(stroke.displacements[i] - aim), 1e-5) << i;
  }
  EXPECT_EQ(placed(studio).stroke, stroke);
  EXPECT_EQ(positions(studio), replayed(studio, stroke));
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
  EXPECT_EQ(tool_of(studio.document().shown().history.front()->strokes), &studio_tool(ToolUse::lattice));
}

// The second drag makes the same stroke larger: the shape is that of both displacements at once.
TEST_F(LatticeGestureTest, OneStrokeGrowsAndUndoTakesBackEachDrag) {
  Studio studio(options());
  run(studio, with_lattice());
  const std::vector<Vec3d> start = positions(studio);
  run(studio, kMoveCorner);
  const std::vector<Vec3d> first = positions(studio);
  const LatticeStroke once = placed(studio).stroke;
  run(studio, R"({"drag": [[-1.04, -1.04, 1.04], [-1.24, -1.04, 1.04]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 1U);
  LatticeStroke both = once;
  both.displacements[2] = {-0.2, 0, 0};
  const LatticeStroke twice = last_lattice(studio);
  for (std::size_t i = 0; i < 27; ++i) EXPECT_LT(norm(twice.displacements[i] - both.displacements[i]), 1e-5) << i;
  const std::vector<Vec3d> second = positions(studio);
  EXPECT_EQ(second, replayed(studio, twice));
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), second);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(placed(studio).stroke, once);
  EXPECT_EQ(positions(studio), first);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(entries(studio), 0U);
  EXPECT_EQ(positions(studio), start);
  EXPECT_EQ(placed(studio).stroke.displacements, std::vector<Vec3d>(27));
  run(studio, R"({"key": "Ctrl+Shift+Z"}
{"key": "Ctrl+Shift+Z"})");
  EXPECT_EQ(placed(studio).stroke, twice);
  EXPECT_EQ(positions(studio), second);
}

// Control points move a box of 2 by 2 by 2 linearly.
TEST_F(LatticeGestureTest, ALineSelectsControlPointsWhichMoveTogether) {
  Studio studio(options());
  run(studio, with_lattice("spline") + kCorners + kRightFace);
  EXPECT_EQ(selected(studio), (std::vector<std::size_t>{4, 5, 6, 7})) << "hidden ones, too";
  EXPECT_EQ(entries(studio), 0U);
  const std::vector<Vec3d> start = positions(studio);
  run(studio, R"({"drag": [[1.04, 1.04, 1.04], [1.56, 1.04, 1.04]]})");
  EXPECT_EQ(errors(studio), "");
  const std::vector<Vec3d> now = positions(studio);
  for (std::size_t i = 0; i < start.size(); ++i) {
    const double u = (start[i].x + kCorner) / (2 * kCorner);
    EXPECT_LT(norm(now[i] - start[i] - Vec3d{0.52 * u, 0, 0}), 1e-5);
  }
  run(studio, R"({"click": [1.56, 1.04, 1.04], "modifiers": ["shift"]})");
  EXPECT_EQ(selected(studio), (std::vector<std::size_t>{4, 5, 6}));
  run(studio,
      R"({"modifiers": ["ctrl"], "drag": [[-1.45, 1.45, 0], [-0.6, 1.45, 0], [-0.6, 0.6, 0], [-1.45, 0.6, 0]]})");
  EXPECT_EQ(selected(studio), (std::vector<std::size_t>{2, 3, 4, 5, 6}));
  run(studio, R"({"click": [-1.04, -1.04, 1.04]})");
  EXPECT_EQ(selected(studio), std::vector<std::size_t>{1});
  run(studio, R"({"click": [0, 0, 0]})");
  EXPECT_TRUE(selected(studio).empty());
  EXPECT_EQ(entries(studio), 1U) << "clicks move nothing";
}

TEST_F(LatticeGestureTest, ADragWhileTheOneBeforeIsComputedIsRefusedAndChangesNothing) {
  Studio studio(options(true));
  run(studio, with_lattice() + R"({"set": {"remesh": true}})");
  run(studio, std::string(kMoveCorner) + R"({"drag": [[1.24, 1.14, 1.04], [1.1, 1.3, 1.04]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 1U);
  EXPECT_EQ(placed(studio).stroke, last_lattice(studio));
  EXPECT_EQ(positions(studio), saved_and_replayed(studio).shape.positions());
}

TEST_F(LatticeGestureTest, EachModeIsItsOwn) {
  for (const char* mode : {"volume", "rigid", "spline"}) {
    Studio studio(options());
    run(studio, with_lattice(mode) + kMoveCorner);
    EXPECT_EQ(errors(studio), "");
    const LatticeStroke stroke = last_lattice(studio);
    EXPECT_EQ(stroke.mode == LatticeMode::spline, std::string(mode) == "spline");
    EXPECT_EQ(stroke.mode == LatticeMode::rigid, std::string(mode) == "rigid");
    EXPECT_EQ(positions(studio), replayed(studio, stroke)) << mode;
  }
}

// Changes of the view and the end of background work do not take a chosen mode back.
TEST_F(LatticeGestureTest, AChosenModeStaysAndShapesWithoutAnExtentHaveNoLattice) {
  Studio studio(options());
  run(studio, with_lattice() + kMoveCorner + R"({"set": {"lattice_mode": "spline"}}
{"key": "Alt+M"}
{"drag": [[1.24, 1.14, 1.04], [1.04, 1.14, 1.04]]})");
  EXPECT_EQ(last_lattice(studio).mode, LatticeMode::spline);
  EXPECT_EQ(entries(studio), 1U);
  std::ofstream(folder_ / "point.obj") << "v 1 2 3\n";
  run(studio, R"({"open": ")" + (folder_ / "point.obj").string() + R"("}
{"tool": "lattice"}
{"drag": [[1, 2, 3], [2, 2, 3]]})");
  EXPECT_TRUE(control_points(placed(studio).stroke).empty());
}

// A control point that goes too far leaves the shape and the lattice at the last sound step.
TEST_F(LatticeGestureTest, AFoldIsRefusedInWords) {
  Studio studio(options());
  run(studio, with_lattice("spline") + kCorners + kRightFace +
                  R"({"drag": [[1.04, 1.04, 1.04], [-1.56, 1.04, 1.04]], "steps": 26})");
  const std::string error = errors(studio);
  EXPECT_NE(error.find("fold"), std::string::npos) << error;
  EXPECT_EQ(error.find('"'), std::string::npos) << "no keys of a session: " << error;
  ASSERT_EQ(entries(studio), 1U);
  const LatticeStroke stroke = last_lattice(studio);
  EXPECT_LT(stroke.displacements[7].x, -1.7);
  EXPECT_GT(stroke.displacements[7].x, -2.08);
  EXPECT_EQ(placed(studio).stroke, stroke);
  EXPECT_EQ(positions(studio), replayed(studio, stroke));
}

TEST_F(LatticeGestureTest, ARefusedFirstDragLeavesTheLatticeAtRest) {
  Studio studio(options(true));
  run(studio, with_lattice("spline"));
  run(studio, kCorners);
  run(studio, kRightFace);
  run(studio, R"({"drag": [[1.04, 1.04, 1.04], [-1.56, 1.04, 1.04]], "steps": 1})");
  EXPECT_NE(errors(studio).find("fold"), std::string::npos);
  EXPECT_EQ(entries(studio), 0U);
  EXPECT_EQ(placed(studio).stroke.displacements, std::vector<Vec3d>(8));
}

// After another tool, Escape or other counts there is a new lattice about the shape as it is.
TEST_F(LatticeGestureTest, ANewLatticeIsAnEntryOfItsOwn) {
  Studio studio(options());
  run(studio, with_lattice() + kMoveCorner + R"({"key": "Escape"})");
  ASSERT_EQ(entries(studio), 1U);
  const auto rests = [&](std::size_t count) {
    return placed(studio).stroke.displacements == std::vector<Vec3d>(count) &&
           bounding_box(control_points(placed(studio).stroke)).max.x > bounding_box(positions(studio)).max.x;
  };
  EXPECT_TRUE(rests(27));
  run(studio, R"({"set": {"lattice_x": 4}})");
  EXPECT_TRUE(rests(36));
  run(studio, R"({"drag": [[-1.04, -1.04, 1.04], [-1.24, -1.04, 1.04]]})");
  EXPECT_EQ(entries(studio), 2U);
  EXPECT_FALSE(rests(36));
  run(studio, R"({"tool": "ball"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1]]}
{"tool": "lattice"})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(entries(studio), 3U);
  EXPECT_TRUE(rests(36));
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_FALSE(rests(36)) << "the last entry is the lattice again, and may grow";
  EXPECT_EQ(placed(studio).stroke, last_lattice(studio));
}

TEST_F(LatticeGestureTest, ASavedLatticeGoesOn) {
  Studio studio(options());
  run(studio, with_lattice() + R"({"set": {"lattice_y": 4}}
)" + kMoveCorner);
  saved_and_replayed(studio);
  Studio again(options());
  run(again, R"({"size": [800, 600]}
{"open": ")" + (folder_ / "work.knead").string() +
                 R"("}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 3}}
{"tool": "lattice"}
{"drag": [[1.24, 1.14, 1.04], [1.14, 1.14, 1.04]]})");
  EXPECT_EQ(errors(again), "");
  ASSERT_EQ(entries(again), 1U);
  EXPECT_LT(norm(last_lattice(again).displacements.back() - Vec3d{0.1, 0.1, 0}), 1e-5);
}

TEST_F(LatticeGestureTest, EscapeAndUndoGiveADragUp) {
  for (const char* key : {"Escape", "Ctrl+Z"}) {
    Studio studio(options());
    run(studio, with_lattice() + kMoveCorner);
    const LatticeStroke once = placed(studio).stroke;
    const std::vector<Vec3d> first = positions(studio);
    run(studio, R"({"press": [1.24, 1.14, 1.04]}
{"move": [1.4, 1.4, 1.04]}
{"key": ")" + std::string(key) +
                    R"("}
{"release": [1.4, 1.4, 1.04]})");
    EXPECT_EQ(errors(studio), "");
    EXPECT_EQ(placed(studio).stroke, once);
    EXPECT_EQ(positions(studio), first);
  }
}

TEST_F(LatticeGestureTest, ATypedDistanceCounts) {
  Studio studio(options());
  run(studio, with_lattice() + R"({"press": [1.04, 1.04, 1.04]}
{"move": [1.14, 1.04, 1.04]}
{"key": "."}
{"key": "3"}
{"key": "Enter"})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 1U);
  EXPECT_LT(norm(last_lattice(studio).displacements.back() - Vec3d{0.3, 0, 0}), 1e-5);
}

TEST_F(LatticeGestureTest, OnlyTheEndOfADragIsRemeshed) {
  Studio studio(options());
  run(studio, with_lattice() + R"({"set": {"remesh": true}}
{"press": [1.04, 1.04, 1.04]}
{"move": [1.34, 1.24, 1.04]})");
  EXPECT_EQ(studio.document().shown().state.positions.size(), 2562U);
  EXPECT_NE(positions(studio), studio.document().shown().start.positions.copy());
  run(studio, R"({"release": [1.34, 1.24, 1.04]})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_TRUE(studio.document().shown().history.front()->strokes.front().remesh.has_value());
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
}

TEST_F(LatticeGestureTest, AMirrorIsNamedPlainly) {
  Studio studio(options());
  run(studio, with_lattice() + R"({"key": "Alt+X"}
)" + kMoveCorner);
  EXPECT_NE(errors(studio).find("Lattice takes the whole shape along"), std::string::npos);
  EXPECT_EQ(entries(studio), 0U);
}

}  // namespace
}  // namespace knead::studio
