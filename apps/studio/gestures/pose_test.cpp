// Poses by pins: one stroke for each drag, kept pins, mirrors, coarse while the pointer moves.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "gestures/gesture_kinds.h"
#include "gestures/gestures_fixture.h"

namespace knead::studio::pose_test {
namespace {

class PoseTest : public GesturesTest {
 protected:
  // A bar along x from -3 to 3, 1 thick, seen from the front, 1 unit 100 pixels, with a pin near each end.
  static std::string bar() {
    return R"({"size": [800, 600]}
{"new": "box", "vertices": 1500}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 6}}
{"tool": "pose"}
{"set": {"pose": "pins", "detail": 0.1, "radius": 1}}
{"click": [-2.8, 0, 0.5]}
{"click": [2.8, 0, 0.5]}
)";
  }

  static PoseStroke last_pose(const Studio& studio) { return std::get<PoseStroke>(last_strokes(studio).front()); }

  static const PosePin& pin_of(const PoseStroke& stroke, std::size_t i) {
    return std::get<PosePin>(stroke.parts.at(i));
  }

  static std::vector<Vec3d> positions_at_start(const Studio& studio) {
    return studio.document().shown().start.positions.copy();
  }

  static const std::vector<Pin>& pins(const Studio& studio) { return studio.tools().placed().pins; }
};

TEST_F(PoseTest, ADragBecomesOneStrokeThatTheCommandRepeats) {
  Studio studio(options());
  run(studio, bar());
  ASSERT_EQ(pins(studio).size(), 2u);
  const std::vector<Pin> before = pins(studio);
  run(studio, R"({"drag": [[2.8, 0, 0.5], [2.6, 0.9, 0.5]], "steps": 3})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1u);
  ASSERT_EQ(last_strokes(studio).size(), 1u);
  const PoseStroke stroke = last_pose(studio);
  EXPECT_EQ(stroke.detail, 0.1);
  ASSERT_EQ(stroke.parts.size(), 2u);
  const PosePin& dragged = pin_of(stroke, 0);
  EXPECT_TRUE(pin_of(stroke, 1).hold);
  EXPECT_EQ(positions_at_start(studio)[*dragged.vertex], before[1].place);
  EXPECT_EQ(positions_at_start(studio)[*pin_of(stroke, 1).vertex], before[0].place);
  EXPECT_LT(norm(dragged.path.back() - before[1].place - Vec3d{-0.2, 0.9, 0}), 0.02);
  EXPECT_TRUE(dragged.turns_freely);
  EXPECT_LT(norm(pins(studio)[1].place - dragged.path.back()), 0.005 * studio.document().shown().diagonal);
  EXPECT_LT(norm(pins(studio)[0].place - before[0].place), 0.005 * studio.document().shown().diagonal);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
}

TEST_F(PoseTest, PinsStayFromDragToDragAndGoBackWithUndo) {
  Studio studio(options());
  run(studio, bar() + R"({"drag": [[2.8, 0, 0.5], [2.7, 0.5, 0.5]], "steps": 2}
)");
  const std::vector<Pin> between = pins(studio);
  run(studio, R"({"drag": [[-2.8, 0, 0.5], [-2.7, 0.4, 0.5]], "steps": 2}
)");
  EXPECT_EQ(studio.document().shown().history.size(), 2u);
  const PoseStroke second = last_pose(studio);
  ASSERT_EQ(second.parts.size(), 2u);
  EXPECT_FALSE(pin_of(second, 0).hold);
  EXPECT_TRUE(pin_of(second, 1).hold) << "what was dragged before holds now";
  run(studio, R"({"key": "Ctrl+Z"})");
  for (const std::size_t i : {0, 1}) EXPECT_EQ(pins(studio)[i].place, between[i].place);
  const auto place = pixel_of(studio.view().screen(), between[1].place);
  run(studio, fmt::format(R"({{"click": [{}, {}], "modifiers": ["alt"]}})", place->x, place->y));
  EXPECT_EQ(pins(studio).size(), 1u);
}

TEST_F(PoseTest, ItIsCoarseWhileThePointerMovesAndHasAllDetailWhenItRests) {
  Studio studio(options(true));
  run(studio, bar());
  const auto press = R"({"press": [2.8, 0, 0.5]}
{"move": [2.7, 0.4, 0.5]}
)";
  std::istringstream lines(press);
  run_script(lines, "script", studio, {});
  EXPECT_EQ(std::get<PoseStroke>(studio.preview().front()).detail, 0.12);
  for (int i = 0; i < 600 && std::get<PoseStroke>(studio.preview().front()).detail != 0.1; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    studio.refresh();
  }
  EXPECT_EQ(std::get<PoseStroke>(studio.preview().front()).detail, 0.1);
  studio.document().worker().wait();
  studio.refresh();
  const std::vector<Vec3d> rested = positions(studio);
  run(studio, R"({"release": [2.7, 0.4, 0.5]})");
  EXPECT_TRUE(positions(studio) == rested) << "letting go changes nothing any more";
  EXPECT_EQ(last_pose(studio).detail, 0.1);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == rested);
  studio.document().close();
}

TEST_F(PoseTest, EscapeLeavesNothing) {
  Studio studio(options());
  run(studio, bar());
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"press": [2.8, 0, 0.5]}
{"move": [2.7, 0.4, 0.5]})");
  EXPECT_FALSE(positions(studio) == before);
  run(studio, R"({"key": "Escape"}
{"release": [2.7, 0.4, 0.5]})");
  EXPECT_TRUE(positions(studio) == before);
  EXPECT_TRUE(studio.document().shown().history.empty());
}

TEST_F(PoseTest, MirroredPinsArePartsOfTheSameStroke) {
  Studio studio(options());
  run(studio, bar() + R"({"set": {"mirror": [true, false, false], "radius": 3}}
{"click": [0, 0, 0.5]}
{"drag": [[2.8, 0, 0.5], [2.7, 0.6, 0.5]], "steps": 2}
)");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(last_strokes(studio).size(), 1u);
  const PoseStroke stroke = last_pose(studio);
  // The pin in the middle is one, and the image of the dragged pin replaces the one that held at the other end.
  ASSERT_EQ(stroke.parts.size(), 3u);
  const auto image = [](const Vec3d& p) { return Vec3d{-p.x, p.y, p.z}; };
  const PosePin& dragged = pin_of(stroke, 0);
  const PosePin& mirrored = pin_of(stroke, 2);
  ASSERT_FALSE(dragged.hold);
  ASSERT_TRUE(mirrored.point);
  EXPECT_EQ(*mirrored.point, image(positions_at_start(studio)[*dragged.vertex]));
  ASSERT_EQ(mirrored.path.size(), dragged.path.size());
  for (std::size_t i = 0; i < dragged.path.size(); ++i) EXPECT_EQ(mirrored.path[i], image(dragged.path[i]));
  EXPECT_TRUE(pin_of(stroke, 1).hold);
  EXPECT_LT(norm(pins(studio)[0].place - image(pins(studio)[1].place)), 0.01 * studio.document().shown().diagonal);
}

TEST_F(PoseTest, AfterARemeshPinsAreNamedByTheirPlaces) {
  Studio studio(options());
  run(studio, bar() + R"({"set": {"remesh": true, "max_edge": 0.2}}
{"drag": [[2.8, 0, 0.5], [2.7, 0.5, 0.5]], "steps": 1}
{"drag": [[2.7, 0.5, 0.5], [2.6, 0.8, 0.5]], "steps": 1}
)");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 2u);
  ASSERT_TRUE(studio.document().shown().state.provenance);
  const PoseStroke stroke = last_pose(studio);
  for (std::size_t i = 0; i < stroke.parts.size(); ++i) {
    EXPECT_EQ(pin_of(stroke, i).point.has_value(), studio.document().shown().state.provenance->is_renumbered);
  }
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
}

TEST_F(PoseTest, ExactPointsAreTheOldPins) {
  Studio studio(options());
  run(studio, bar() + R"({"set": {"pose": "exact"}}
{"drag": [[2.8, 0, 0.5], [2.7, 0.5, 0.5]], "steps": 1}
)");
  ASSERT_EQ(last_strokes(studio).size(), 1u);
  EXPECT_TRUE(std::holds_alternative<PinsStroke>(last_strokes(studio).front()));
  run(studio, R"({"tool": "ball"}
{"tool": "pose"})");
  EXPECT_EQ(studio.tools().settings().pose, PoseMode::exact) << "the tool keeps its mode";
}

TEST(HoldingLess, FreesWhatIsNearToWhatMovesAndNothingElse) {
  std::vector<Vec3d> line;
  for (int i = 0; i < 100; ++i) line.push_back({0.01 * i, 0, 0});
  PoseStroke pose;
  PosePart moving;
  moving.vertices = {{90, 99}};
  moving.translation = Vec3d{0, 0.1, 0};
  PosePart held;
  held.vertices = {{0, 85}};
  held.hold = true;
  PosePin pin;
  pin.point = Vec3d{0.8, 0, 0};
  pin.hold = true;
  pose.parts = {moving, held, pin};
  const PoseStroke less = holding_less(pose, line, 0.201);
  ASSERT_EQ(less.parts.size(), 2u);
  EXPECT_EQ(std::get<PosePart>(less.parts[0]), moving);
  EXPECT_EQ(std::get<PosePart>(less.parts[1]).vertices, (std::vector<VertexRange>{{0, 69}}));
  // The second time the gap grows.
  EXPECT_LT(std::get<PosePart>(holding_less(less, line, 0.201).parts[1]).vertices.back().last, 60u);
  EXPECT_EQ(holding_less(pose, line, 10), pose) << "something must hold";
  // The same by points.
  held.vertices.clear();
  held.points.assign(line.begin(), line.begin() + 86);
  pose.parts[1] = held;
  EXPECT_EQ(std::get<PosePart>(holding_less(pose, line, 0.201).parts[1]).points.size(), 70u);
}

TEST(ExtendPath, KeepsTheWayInPiecesAndGoesBackWithThePointer) {
  const Vec3d start{0, 0, 0};
  std::vector<Vec3d> path;
  const auto go = [&](double x, double y) { extend_path(start, {x, y, 0}, 1, path); };
  for (int i = 1; i <= 40; ++i) go(0.25 * i, 0);
  for (int i = 1; i <= 40; ++i) go(10, 0.25 * i);
  ASSERT_GT(path.size(), 5u);
  EXPECT_EQ(path.back(), (Vec3d{10, 10, 0}));
  double length = norm(path.front());
  for (std::size_t i = 1; i < path.size(); ++i) length += norm(path[i] - path[i - 1]);
  EXPECT_NEAR(length, 20, 0.5) << "round the corner";
  for (std::size_t i = 2; i < path.size(); ++i) EXPECT_GE(norm(path[i - 1] - path[i - 2]), 1);
  for (int i = 1; i <= 40; ++i) go(10, 10 - 0.25 * i);
  for (int i = 1; i <= 24; ++i) go(10 - 0.25 * i, 0);
  EXPECT_LE(path.size(), 5u);
  EXPECT_EQ(path.back(), (Vec3d{4, 0, 0}));
  go(0.2, 0);
  EXPECT_EQ(path, (std::vector<Vec3d>{{0.2, 0, 0}}));
}

}  // namespace
}  // namespace knead::studio::pose_test
