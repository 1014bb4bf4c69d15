// The line through the shape: its handles, drawn lines, what is refused, and undo.
#include <algorithm>
#include <cmath>
#include <fstream>

#include "document/layers.h"
#include "gestures/gestures_fixture.h"
#include "knead/editor/tools.h"

namespace knead::studio {
namespace {

constexpr double kHalf = 3;                 // of the bar
constexpr double kTip = kHalf * 128 / 122;  // of the line

class BendAlongTest : public GesturesTest {
 protected:
  // A bar of 6 by 0.5 by 0.5 along x, seen from the front, 1 unit 100 pixels, the middle at (400, 300); the tool.
  std::string bar() const {
    constexpr int kRings = 61;
    std::ofstream file(folder_ / "bar.obj");
    for (int i = 0; i < kRings; ++i) {
      for (const auto& [y, z] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        file << "v " << kHalf * (2.0 * i / (kRings - 1) - 1) << ' ' << 0.25 * y << ' ' << 0.25 * z << '\n';
      }
    }
    const auto face = [&](int a, int b, int c, int d) {
      file << "f " << a << ' ' << b << ' ' << c << ' ' << d << '\n';
    };
    for (int i = 0; i + 1 < kRings; ++i) {
      for (int k = 0; k < 4; ++k) {
        const int a = 4 * i + k + 1;
        const int b = 4 * i + (k + 1) % 4 + 1;
        face(a, b, b + 4, a + 4);
      }
    }
    face(4, 3, 2, 1);
    const int last = 4 * (kRings - 1);
    face(last + 1, last + 2, last + 3, last + 4);
    return R"({"size": [800, 600]}
{"open": ")" +
           (folder_ / "bar.obj").string() + R"("}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 6}}
{"tool": "bend_along"}
)";
  }

  static const std::vector<Vec3d>& line(const Studio& studio) { return studio.tools().placed().line; }

  static CurveStroke last_stroke(const Studio& studio) { return std::get<CurveStroke>(last_strokes(studio).front()); }

  static std::size_t entries(const Studio& studio) { return studio.document().shown().history.size(); }

  // The greatest distance of a place on the line through the shape's points from what `of` says, which is 0 on it.
  template <class Of>
  static double farthest(const Studio& studio, const Of& of) {
    double most = 0;
    for (const Vec3d& p : points_on_line(line(studio), 50)) most = std::max(most, std::abs(of(p)));
    return most;
  }
};

constexpr const char* kLiftEnd = R"({"drag": [[3.147541, 0, 0], [2.747541, 1, 0]]})";

TEST_F(BendAlongTest, TheLineIsTheLongestAxisUntilAHandleMovesIt) {
  Studio studio(options());
  run(studio, bar());
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(line(studio).size(), 17U);
  EXPECT_EQ(studio.tools().placed().line_stride, 4U);
  for (std::size_t i = 0; i < 17; ++i) {
    EXPECT_LT(norm(line(studio)[i] - Vec3d{kTip * (static_cast<double>(i) / 8 - 1), 0, 0}), 1e-12) << i;
  }
  run(studio, kLiftEnd);
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 1U);
  const CurveStroke stroke = last_stroke(studio);
  EXPECT_EQ(stroke.fixed, CurveFixed::start);
  EXPECT_EQ(stroke.from.size(), 2U) << "a straight line";
  EXPECT_LT(norm(stroke.to.back() - Vec3d{kTip - 0.4, 1, 0}), 1e-5);
  EXPECT_LT(norm(line(studio).front() - Vec3d{-kTip, 0, 0}), 1e-9) << "the other end holds";
  const std::vector<Vec3d> now = positions(studio);
  const double highest =
      std::max_element(now.begin(), now.end(), [](const Vec3d& a, const Vec3d& b) { return a.y < b.y; })->y;
  EXPECT_NEAR(highest, 1.1, 0.15);
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), now);
}

// The next drag begins with the handles in the bent shape; undo and redo take them back and forth.
TEST_F(BendAlongTest, HandlesStayInTheShape) {
  Studio studio(options());
  run(studio, bar());
  const std::vector<Vec3d> straight = line(studio);
  const std::vector<Vec3d> start = positions(studio);
  run(studio, kLiftEnd);
  const std::vector<Vec3d> once = line(studio);
  const std::vector<Vec3d> first = positions(studio);
  run(studio, R"({"drag": [[0, 0, 0], [0, -0.5, 0]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 2U);
  EXPECT_EQ(last_stroke(studio).from, once);
  EXPECT_LT(line(studio)[8].y, -0.3);
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
  const std::vector<Vec3d> twice = line(studio);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(line(studio), once);
  EXPECT_EQ(positions(studio), first);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(line(studio), straight);
  EXPECT_EQ(positions(studio), start);
  run(studio, R"({"key": "Ctrl+Shift+Z"}
{"key": "Ctrl+Shift+Z"})");
  EXPECT_EQ(line(studio), twice);
}

TEST_F(BendAlongTest, TheShapeFollowsADrawnLineInEitherDirection) {
  std::string places;
  std::string backwards;
  for (int i = 0; i <= 24; ++i) {
    const double angle = 3.14159 * (1 - i / 24.0);
    const std::string place = "[" + std::to_string(1.9 * std::cos(angle)) + ", " +
                              std::to_string(1.9 * std::sin(angle) + 0.01 * (i % 2)) + ", 0]";
    places += (i > 0 ? ", " : "") + place;
    backwards = place + (i > 0 ? ", " : "") + backwards;
  }
  for (const std::string& drawn : {places, backwards}) {
    Studio studio(options());
    run(studio, bar() + R"({"drag": [)" + drawn + "]}");
    EXPECT_EQ(errors(studio), "");
    ASSERT_EQ(entries(studio), 1U);
    EXPECT_LT(farthest(studio, [](const Vec3d& p) { return norm(p) - 1.9; }), 0.08);
    EXPECT_LT(line(studio).front().x, 0) << "the left end stays on the left";
    double length = 0;
    const std::vector<Vec3d> along = points_on_line(line(studio), 200);
    for (std::size_t i = 1; i < along.size(); ++i) length += norm(along[i] - along[i - 1]);
    EXPECT_NEAR(length, 2 * kTip, 0.05) << "its length is kept";
    EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
  }
}

TEST_F(BendAlongTest, TheHistoryNamesTheTool) {
  Studio studio(options());
  run(studio, bar() + kLiftEnd);
  EXPECT_EQ(tool_of(studio.document().shown().history.front()->strokes), &studio_tool(ToolUse::bend_along));
}

TEST_F(BendAlongTest, TheThicknessIsKeptIfThatIsSet) {
  Studio studio(options());
  run(studio, bar() + R"({"set": {"bend_keep": "thickness"}}
)" + kLiftEnd);
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(last_stroke(studio).keep, CurveKeeps::thickness);
}

TEST_F(BendAlongTest, TheShapeIsStretchedToTheEndsIfThatIsSet) {
  Studio studio(options());
  run(studio, bar() + R"({"set": {"bend_length": "fit"}}
{"drag": [[3.147541, 0, 0], [3.947541, 0, 0]]})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_LT(norm(line(studio).back() - Vec3d{kTip + 0.8, 0, 0}), 1e-5);
}

// A handle that goes too far leaves the shape at its last sound step; a drawn line that is too tight changes nothing.
TEST_F(BendAlongTest, WhatIsTooTightIsRefusedInWords) {
  Studio studio(options());
  run(studio, bar());
  const std::vector<Vec3d> start = positions(studio);
  run(studio, R"({"drag": [[-0.2, 0.6, 0], [0.2, 0.6, 0], [0.2, 0.2, 0], [-0.2, 0.2, 0], [-0.2, 0.6, 0]]})");
  const std::string error = errors(studio);
  EXPECT_NE(error.find("line that bends at most"), std::string::npos) << error;
  EXPECT_EQ(error.find('"'), std::string::npos) << "no keys of a session: " << error;
  EXPECT_EQ(positions(studio), start);
  EXPECT_EQ(entries(studio), 0U);
  EXPECT_LT(norm(line(studio).back() - Vec3d{kTip, 0, 0}), 1e-12) << "the handles are back in the shape";
  run(studio, R"({"drag": [[0, 0, 0], [0, 1, 0], [0, 9, 0]], "steps": 20})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 1U);
  EXPECT_GT(last_stroke(studio).to[8].y, 0.9);
  EXPECT_LT(last_stroke(studio).to[8].y, 9);
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
}

TEST_F(BendAlongTest, EscapeGivesUpADragAndThenMakesTheLineStraight) {
  Studio studio(options());
  run(studio, bar() + R"({"press": [3.147541, 0, 0]}
{"move": [2.6, 1, 0]}
{"key": "Escape"}
{"release": [2.6, 1, 0]})");
  EXPECT_EQ(entries(studio), 0U);
  run(studio, std::string(kLiftEnd) + R"(
{"key": "Escape"})");
  ASSERT_EQ(entries(studio), 1U);
  const Box box = bounding_box(positions(studio));
  const std::vector<Vec3d> expected = longest_axis(box, 17);
  EXPECT_EQ(line(studio), expected);
  run(studio, R"({"tool": "ball"}
{"tool": "bend_along"}
{"drag": [[0, )" + std::to_string(expected[8].y) +
                  R"(, 0], [0, -0.3, 0]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 2U);
  EXPECT_EQ(last_stroke(studio).from.size(), 2U);
}

TEST_F(BendAlongTest, AMirrorOrAMaskIsNamedPlainly) {
  Studio studio(options());
  run(studio, bar() + R"({"key": "Alt+X"}
)" + kLiftEnd);
  EXPECT_NE(errors(studio).find("switch the mirror"), std::string::npos);
  run(studio, R"({"key": "Alt+X"}
{"tool": "mask"}
{"set": {"radius": 0.6}}
{"click": [2, 0, 0]}
{"tool": "bend_along"}
)" + std::string(kLiftEnd));
  EXPECT_NE(errors(studio).find("remove the mask"), std::string::npos);
  EXPECT_EQ(entries(studio), 1U) << "the mask alone";
}

TEST_F(BendAlongTest, AClickAndAShortSlipDoNothing) {
  Studio studio(options());
  run(studio, bar() + R"({"click": [0, 0, 0]}
{"click": [0.7, 1, 0]}
{"drag": [[0.7, 1, 0], [0.9, 1.1, 0]]}
{"drag": [[0, 0, 0], [0.02, 0, 0]]})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(entries(studio), 0U);
}

TEST_F(BendAlongTest, ThePressedHandleTakesATypedDistance) {
  Studio studio(options());
  run(studio, bar() + R"({"press": [3.147541, 0, 0]}
{"move": [3.147541, 0.4, 0]}
{"key": "1"}
{"key": "Enter"})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(entries(studio), 1U);
  EXPECT_LT(norm(last_stroke(studio).to.back() - Vec3d{kTip, 1, 0}), 1e-5);
}

}  // namespace
}  // namespace knead::studio
