// Several pins: selected, dragged together, and brought back after a crash.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "gestures/gesture.h"
#include "gestures/gestures_fixture.h"

namespace knead::studio::selected_pins_test {
namespace {

// Selects the second and third pin.
constexpr const char* kSelectTwo = R"({"click": [0.5, 0, 0.866], "modifiers": ["shift"]}
{"click": [0, 0.5, 0.866], "modifiers": ["shift"]}
)";

std::vector<bool> selected(const std::vector<Pin>& pins) {
  std::vector<bool> result;
  for (const Pin& pin : pins) result.push_back(pin.is_selected);
  return result;
}

TEST_F(PinsTest, ShiftAndAClickSelectsAPinAndMovesNothing) {
  Studio studio(options());
  run(studio, three_pins() + kSelectTwo);
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{false, true, true}));
  EXPECT_TRUE(studio.document().shown().history.empty());
  run(studio, R"({"click": [0.5, 0, 0.866], "modifiers": ["shift"]})");
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{false, false, true}));
  run(studio, R"({"key": "Escape"})");
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{false, false, false}));
  EXPECT_EQ(pins(studio).size(), 3u);
  run(studio, R"({"drag": [[-0.4, -0.4, 0.8], [0.4, -0.4, 0.8]], "modifiers": ["shift"]})");
  EXPECT_TRUE(std::holds_alternative<RelaxStroke>(last_strokes(studio).front())) << "where no pin is, Shift relaxes";
}

TEST_F(PinsTest, ADragOfASelectedPinTakesAllSelectedAlong) {
  Studio studio(options());
  run(studio, three_pins() + kSelectTwo);
  const std::vector<Pin> before = pins(studio);
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.8, 0.1, 0.866]]})");
  const PinsStroke stroke = last_stroke(studio);
  ASSERT_EQ(stroke.points.size(), 3u);
  const Vec3d by = stroke.to[1] - stroke.points[1];
  EXPECT_LT(norm(by - Vec3d{0.3, 0.1, 0}), 0.01);
  EXPECT_LT(norm(stroke.to[2] - stroke.points[2] - by), 1e-15);
  EXPECT_EQ(stroke.to[0], stroke.points[0]) << "what is not selected holds";
  for (const std::size_t i : {0, 1, 2}) {
    EXPECT_LE(norm(pins(studio)[i].place - stroke.to[i]), slack(studio));
    EXPECT_TRUE(is_on_vertex(studio, pins(studio)[i]));
  }
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{false, true, true})) << "for the next drag";
  EXPECT_EQ(studio.document().shown().history.size(), 1u);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
  run(studio, R"({"key": "Ctrl+Z"})");
  for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(pins(studio)[i].place, before[i].place) << "one step";
  EXPECT_EQ(errors(studio), "");
}

TEST_F(PinsTest, APinThatIsNotSelectedIsDraggedAlone) {
  Studio studio(options());
  run(studio, three_pins() + kSelectTwo + R"({"drag": [[-0.4, 0, 0.917], [-0.6, 0.1, 0.917]]})");
  const PinsStroke stroke = last_stroke(studio);
  EXPECT_NE(stroke.to[0], stroke.points[0]);
  for (const std::size_t i : {1, 2}) EXPECT_EQ(stroke.to[i], stroke.points[i]);
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{false, true, true}));
}

TEST_F(PinsTest, ASelectedFreePinMovesWithTheOthersAndEscapeTakesAllBack) {
  Studio studio(options());
  run(studio, three_pins() + R"({"double_click": [0, 0.5, 0.866]}
)" + kSelectTwo);
  const std::vector<Pin> before = pins(studio);
  const std::vector<Vec3d> shape = positions(studio);
  ASSERT_FALSE(before[2].holds);
  run(studio, R"({"press": [0, 0.5, 0.866]}
{"move": [0.1, 0.7, 0.866]})");
  EXPECT_NE(positions(studio), shape);
  run(studio, R"({"key": "Escape"}
{"release": [0.1, 0.7, 0.866]})");
  EXPECT_TRUE(positions(studio) == shape);
  for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(pins(studio)[i].place, before[i].place);
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.6, 0.2, 0.866]]})");
  const PinsStroke stroke = last_stroke(studio);
  ASSERT_EQ(stroke.points.size(), 3u);
  EXPECT_LT(norm((stroke.to[2] - stroke.points[2]) - (stroke.to[1] - stroke.points[1])), 1e-15);
  EXPECT_FALSE(pins(studio)[2].holds);
}

TEST_F(PinsTest, ALassoSelectsWhatIsWithinItAndSetsNone) {
  Studio studio(options());
  run(studio, three_pins() + R"({"set": {"lasso_selects": true}}
{"drag": [[350, 160], [550, 160], [550, 350], [350, 350], [350, 160]]}
)");
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{false, true, true}));
  EXPECT_TRUE(studio.document().shown().history.empty());
  run(studio, R"({"drag": [[270, 250], [350, 250], [350, 350], [270, 350], [270, 250]]})");
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{true, false, false})) << "in the place of those before";
  run(studio, R"({"click": [0, -0.4, 0.9]})");
  EXPECT_EQ(selected(pins(studio)), (std::vector<bool>{false, false, false})) << "a click beside the pins";
  EXPECT_EQ(pins(studio).size(), 3u);
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.6, 0, 0.866]]})");
  EXPECT_EQ(studio.document().shown().history.size(), 1u) << "a pin is dragged all the same";
  run(studio, R"({"drag": [[350, 400], [450, 400], [450, 480], [350, 480], [350, 400]], "modifiers": ["ctrl"]})");
  EXPECT_GT(pins(studio).size(), 3u) << "with Ctrl it sets pins";
}

TEST_F(PinsTest, SelectedPinsAreMirrored) {
  Studio studio(options());
  // Two on the right, one in the plane, and one on the left that is the image of the first.
  run(studio, ball(10242) + R"({"tool": "pins"}
{"set": {"mirror": [true, false, false], "radius": 0.5}}
{"click": [0.5, 0, 0.866]}
{"click": [0.4, 0.5, 0.77]}
{"click": [0, -0.526, 0.851]}
{"click": [-0.5, 0, 0.866]}
)");
  ASSERT_EQ(pins(studio).size(), 4u);
  studio.tools().select_pins(true);
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.7, 0.1, 0.866]]})");
  const PinsStroke stroke = last_stroke(studio);
  const auto image = [](const Vec3d& p) { return Vec3d{-p.x, p.y, p.z}; };
  ASSERT_EQ(stroke.points.size(), 5u) << "the pin on the left is the image of the first";
  const Vec3d by = stroke.to[0] - stroke.points[0];
  EXPECT_LT(norm(by - Vec3d{0.2, 0.1, 0}), 0.01);
  EXPECT_LT(norm(stroke.to[1] - stroke.points[1] - by), 1e-15);
  EXPECT_NEAR(stroke.to[2].x, 0, slack(studio)) << "the pin in the plane stays in it";
  EXPECT_NEAR(stroke.to[2].y - stroke.points[2].y, by.y, 1e-12);
  for (const std::size_t i : {0, 1}) {
    EXPECT_EQ(stroke.points[3 + i], image(stroke.points[i]));
    EXPECT_EQ(stroke.to[3 + i], image(stroke.to[i]));
  }
  // It was within a tenth of the radius of its image, and goes where that goes.
  EXPECT_LT(norm(pins(studio)[3].place - image(stroke.to[0])), 0.07);
  EXPECT_EQ(errors(studio), "");
}

TEST_F(PinsTest, NumbersMoveAllSelectedPins) {
  Studio studio(options());
  run(studio, three_pins() + kSelectTwo);
  const Vec3d by{0.05, 0.1, -0.02};
  studio.move_pin(2, pins(studio)[2].place + by);
  run(studio, R"({"wait": true})");
  const PinsStroke stroke = last_stroke(studio);
  for (const std::size_t i : {1, 2}) EXPECT_LT(norm(stroke.to[i] - stroke.points[i] - by), 1e-15);
  EXPECT_EQ(stroke.to[0], stroke.points[0]);
}

// As they are between two gestures: on their vertices, held or free, with the radius.
TEST_F(PinsTest, PinsComeBackAfterACrash) {
  for (const bool has_worker : {false, true}) {
    for (const bool remeshes : {false, true}) {
      SCOPED_TRACE(fmt::format("worker {}, remesh {}", has_worker, remeshes));
      std::vector<Pin> before;
      double radius = 0;
      {
        Studio studio(options(has_worker));
        run(studio, three_pins(2562) + R"({"double_click": [0, 0.5, 0.866]}
)");
        if (remeshes) run(studio, R"({"set": {"remesh": true, "max_edge": 0.06}})");
        run(studio, R"({"drag": [[0.5, 0, 0.866], [1, 0.3, 0.866]]}
{"key": "["}
{"move": [400, 300]})");
        before = pins(studio);
        radius = studio.tools().radius();
      }
      Studio next(options(has_worker));
      ASSERT_EQ(next.document().abandoned().size(), 1u);
      run(next, R"({"size": [800, 600]}
{"recover": "newest"})");
      EXPECT_EQ(errors(next), "");
      ASSERT_EQ(pins(next).size(), 3u);
      for (const std::size_t i : {0, 1, 2}) {
        EXPECT_EQ(pins(next)[i].place, before[i].place);
        EXPECT_EQ(pins(next)[i].holds, i != 2);
        EXPECT_TRUE(is_on_vertex(next, pins(next)[i]));
      }
      EXPECT_EQ(next.tools().radius(), radius);
      EXPECT_EQ(next.tools().settings().tool->use, ToolUse::pose);
      run(next, R"({"key": "Ctrl+Z"})");
      for (const Pin& pin : pins(next)) EXPECT_TRUE(is_on_vertex(next, pin));
      next.document().close();
    }
  }
}

// The strokes of the drag come back; so the pins are where their vertices are now.
TEST_F(PinsTest, AfterACrashInADragThePinsAreWhereItHadTakenThem) {
  std::vector<Vec3d> shape;
  std::vector<Vec3d> goals;
  {
    Studio studio(options());
    run(studio, three_pins() + R"({"move": [400, 300]}
{"press": [0.5, 0, 0.866]}
{"move": [0.7, 0.1, 0.866]}
{"move": [0.8, 0.2, 0.866]})");
    shape = positions(studio);
    goals = std::get<PinsStroke>(studio.preview().front()).to;
  }
  Studio next(options());
  run(next, R"({"size": [800, 600]}
{"recover": "newest"})");
  EXPECT_TRUE(positions(next) == shape);
  ASSERT_EQ(pins(next).size(), 3u);
  for (const std::size_t i : {0, 1, 2}) EXPECT_LE(norm(pins(next)[i].place - goals[i]), slack(next));
  next.document().close();
}

TEST_F(PinsTest, AScriptSetsPins) {
  Studio studio(options());
  run(studio,
      ball() +
          R"({"pins": [{"place": [0.5, 0, 0.9]}, {"place": [0, 0, 0], "vertex": 17, "holds": false}, {"place": [0, 1.1, 0], "vertex": 3}], "of": 2562}
)");
  const std::vector<Vec3d> now = positions(studio);
  ASSERT_EQ(pins(studio).size(), 3u);
  EXPECT_LT(norm(pins(studio)[0].place - Vec3d{0.5, 0, 0.866}), 0.05);
  EXPECT_TRUE(is_on_vertex(studio, pins(studio)[0]));
  EXPECT_EQ(pins(studio)[1].place, now[17]);
  EXPECT_FALSE(pins(studio)[1].holds);
  EXPECT_EQ(pins(studio)[2].place, now[3]);
  run(studio, R"({"pins": [{"place": [0, 1.1, 0], "vertex": 3}], "of": 2563})");
  ASSERT_EQ(pins(studio).size(), 1u);
  EXPECT_LT(norm(pins(studio)[0].place - Vec3d{0, 1, 0}), 0.05) << "vertex 3 of another shape";
  EXPECT_THROW(run(studio, R"({"pins": [{"vertex": 3}]})"), InvalidInput);
}

}  // namespace
}  // namespace knead::studio::selected_pins_test
