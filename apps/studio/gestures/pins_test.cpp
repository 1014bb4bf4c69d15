// Pins: set, dragged one at a time, freed, mirrored, and carried along with the shape.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gestures/gesture.h"
#include "gestures/gestures_fixture.h"
#include "view/overlay.h"

namespace knead::studio::pins_test {
namespace {

TEST_F(PinsTest, AClickSetsAPinOnTheNearestVertexAndMovesNothing) {
  Studio studio(options());
  run(studio, three_pins());
  ASSERT_EQ(pins(studio).size(), 3u);
  EXPECT_TRUE(studio.document().shown().history.empty());
  const double edge = std::sqrt(4 * std::numbers::pi / 10242 * 2 / std::sqrt(3.0));  // of about 2 triangles a vertex
  EXPECT_LT(norm(pins(studio)[1].place - Vec3d{0.5, 0, std::sqrt(0.75)}), edge);
  for (const Pin& pin : pins(studio)) EXPECT_TRUE(is_on_vertex(studio, pin));
  run(studio, R"({"click": [0.5, 0, 0.866]}
{"click": [-1.5, 1, 0]})");
  EXPECT_EQ(pins(studio).size(), 3u) << "a click on a pin or beside the shape sets none";
}

TEST_F(PinsTest, ADragTakesAPinToItsPlaceAndTheOthersHold) {
  Studio studio(options());
  run(studio, three_pins());
  const std::vector<Pin> before = pins(studio);
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.8, 0.1, 0.866]]})");
  const PinsStroke first = last_stroke(studio);
  EXPECT_TRUE(first.radius_auto);
  ASSERT_EQ(first.points.size(), 3u);
  for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(first.points[i], before[i].place);
  EXPECT_EQ(first.to[0], first.points[0]);
  EXPECT_EQ(first.to[2], first.points[2]);
  EXPECT_LT(norm(first.to[1] - first.points[1] - Vec3d{0.3, 0.1, 0}), 0.01) << "by as much as the pointer";
  for (const std::size_t i : {0, 1, 2}) {
    EXPECT_LE(norm(pins(studio)[i].place - first.to[i]), slack(studio));
    EXPECT_TRUE(is_on_vertex(studio, pins(studio)[i]));
    EXPECT_TRUE(pins(studio)[i].holds);
  }

  // The next drag begins with the pins where this one has left them.
  const std::vector<Pin> between = pins(studio);
  run(studio, R"({"drag": [[-0.4, 0, 0.9], [-0.5, -0.2, 0.9]]})");
  const PinsStroke second = last_stroke(studio);
  EXPECT_EQ(studio.document().shown().history.size(), 2u);
  for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(second.points[i], between[i].place);
  EXPECT_EQ(second.to[1], second.points[1]) << "what was dragged before holds now";
  EXPECT_LE(norm(pins(studio)[1].place - second.points[1]), slack(studio));
  EXPECT_EQ(errors(studio), "");
}

TEST_F(PinsTest, APressBesideThePinsSetsOneAndDragsItAndEscapeLeavesNothing) {
  Studio studio(options());
  run(studio, three_pins());
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"press": [0, -0.3, 0.95]}
{"move": [0, -0.5, 0.95]})");
  EXPECT_NE(positions(studio), before);
  EXPECT_TRUE(studio.gesture());
  run(studio, R"({"key": "Escape"}
{"release": [0, -0.5, 0.95]})");
  EXPECT_TRUE(positions(studio) == before);
  EXPECT_TRUE(studio.document().shown().history.empty());
  EXPECT_EQ(pins(studio).size(), 3u);
  run(studio, R"({"drag": [[0, -0.3, 0.95], [0, -0.5, 0.95]]})");
  EXPECT_EQ(pins(studio).size(), 4u);
  EXPECT_EQ(last_stroke(studio).points.size(), 4u);
  run(studio, R"({"key": "Escape"})");
  EXPECT_EQ(pins(studio).size(), 4u) << "Escape removes no pins";
}

TEST_F(PinsTest, ADistanceIsTypedDuringADrag) {
  Studio studio(options());
  run(studio, three_pins() + R"({"press": [0.5, 0, 0.866]}
{"move": [0.6, 0, 0.866]}
{"key": "."}
{"key": "3"}
)");
  const std::vector<std::string> lines = numbers_at_pointer(studio);
  ASSERT_GE(lines.size(), 2u);
  EXPECT_EQ(lines[0], "Distance .3_");
  EXPECT_EQ(lines[1], fmt::format("Radius {:.4g}", *radius_of(std::get<PinsStroke>(studio.preview().front()))));
  run(studio, R"({"key": "Enter"})");
  const PinsStroke stroke = last_stroke(studio);
  EXPECT_NEAR(norm(stroke.to[1] - stroke.points[1]), 0.3, 1e-12);
}

TEST_F(PinsTest, AltAndAClickRemovesAPinAndDoesNotTurnTheView) {
  Studio studio(options());
  run(studio, three_pins());
  const double yaw = studio.view().navigation().view.yaw;
  const Vec3d last = pins(studio)[2].place;
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.9, 0, 0.866]], "modifiers": ["alt"]})");
  ASSERT_EQ(pins(studio).size(), 2u);
  EXPECT_EQ(pins(studio)[1].place, last);
  EXPECT_EQ(studio.view().navigation().view.yaw, yaw);
  EXPECT_TRUE(studio.document().shown().history.empty());
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.9, 0, 0.866]], "modifiers": ["alt"]})");
  EXPECT_NE(studio.view().navigation().view.yaw, yaw) << "where no pin is, it does";
}

TEST_F(PinsTest, ADoubleClickMakesAPinFreeAndThenItGoesWithTheSurface) {
  Studio studio(options());
  run(studio, three_pins() + R"({"double_click": [0, 0.5, 0.866]})");
  EXPECT_FALSE(pins(studio)[2].holds);
  EXPECT_TRUE(studio.document().shown().history.empty());
  const Vec3d before = pins(studio)[2].place;
  run(studio, R"({"drag": [[0.5, 0, 0.866], [0.6, 0.4, 0.866]]})");
  EXPECT_EQ(last_stroke(studio).points.size(), 2u);
  EXPECT_GT(norm(pins(studio)[2].place - before), 0.01);
  EXPECT_TRUE(is_on_vertex(studio, pins(studio)[2]));
  const auto pixel = pixel_of(studio.view().screen(), pins(studio)[2].place);
  const std::string place = fmt::format("[{}, {}]", pixel->x, pixel->y);
  run(studio, fmt::format(R"({{"drag": [{}, [400, 120]]}})", place));
  EXPECT_EQ(last_stroke(studio).points.size(), 3u) << "a free pin can be dragged";
  run(studio, R"({"double_click": [400, 120]})");
  EXPECT_TRUE(pins(studio)[2].holds);
}

TEST_F(PinsTest, UndoAndRedoTakeThePinsAlong) {
  for (const bool remeshes : {false, true}) {
    for (const bool has_worker : {false, true}) {
      Studio studio(options(has_worker));
      run(studio, three_pins(2562));
      const std::vector<Pin> before = pins(studio);
      const std::shared_ptr<const Mesh> mesh = studio.document().shown().state.mesh;
      if (remeshes) run(studio, R"({"set": {"remesh": true, "max_edge": 0.06}})");
      run(studio, R"({"drag": [[0.5, 0, 0.866], [1, 0.3, 0.866]]})");
      ASSERT_EQ(studio.document().shown().state.mesh != mesh, remeshes);
      const std::vector<Pin> after = pins(studio);
      EXPECT_GT(norm(after[1].place - before[1].place), 0.4);
      for (const Pin& pin : after) EXPECT_TRUE(is_on_vertex(studio, pin));
      run(studio, R"({"key": "Ctrl+Z"})");
      for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(pins(studio)[i].place, before[i].place);
      run(studio, R"({"key": "Ctrl+Shift+Z"})");
      for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(pins(studio)[i].place, after[i].place);
      studio.document().close();
    }
  }
}

TEST_F(PinsTest, OtherToolsCarryThePinsAlong) {
  Studio studio(options());
  run(studio, three_pins());
  const std::vector<Pin> before = pins(studio);
  run(studio, R"({"tool": "ball"}
{"drag": [[0.5, 0, 0.866], [0.8, 0, 0.866]]})");
  EXPECT_GT(norm(pins(studio)[1].place - before[1].place), 0.2);
  EXPECT_EQ(pins(studio)[0].place, before[0].place);
  for (const Pin& pin : pins(studio)) EXPECT_TRUE(is_on_vertex(studio, pin));
  EXPECT_FALSE(studio.pointed_pin()) << "no other tool takes hold of pins";
}

TEST_F(PinsTest, PinsAreMirroredAndStaySymmetric) {
  Studio studio(options());
  run(studio, ball(10242) + R"({"tool": "pins"}
{"set": {"mirror": [true, false, false]}}
{"click": [0, -0.526, 0.851]}
{"click": [-0.5, 0, 0.866]}
{"drag": [[0.5, 0, 0.866], [0.7, 0.3, 0.866]]})");
  const PinsStroke stroke = last_stroke(studio);
  // The pin in the plane is one, and the image of the dragged pin replaces what is held there.
  ASSERT_EQ(stroke.points.size(), 3u);
  const auto image = [](const Vec3d& p) { return Vec3d{-p.x, p.y, p.z}; };
  EXPECT_EQ(stroke.points[2], image(stroke.points[1]));
  EXPECT_EQ(stroke.to[2], image(stroke.to[1]));
  EXPECT_NE(stroke.to[1], stroke.points[1]);
  const std::vector<Vec3d> start = studio.document().shown().state.mesh->positions;
  const std::vector<Vec3d> now = positions(studio);
  double worst = 0;
  for (std::size_t i = 0; i < now.size(); i += 7) {
    const auto other = std::ranges::min_element(start, {}, [&](const Vec3d& p) { return norm2(p - image(start[i])); });
    worst = std::max(worst, norm(now[static_cast<std::size_t>(other - start.begin())] - image(now[i])));
  }
  EXPECT_LE(worst, slack(studio));

  // A pin in the plane stays in it.
  run(studio, R"({"drag": [[0, -0.526, 0.851], [0.3, -0.7, 0.851]]})");
  EXPECT_NEAR(last_stroke(studio).to[0].x, 0, slack(studio));
  EXPECT_LT(last_stroke(studio).to[0].y, -0.6);
  EXPECT_EQ(errors(studio), "");
}

TEST_F(PinsTest, ALassoSetsPinsEvenlyAndFewTwice) {
  Studio studio(options());
  run(studio, ball(10242) + R"({"tool": "pins"}
{"drag": [[200, 200], [600, 200], [600, 290], [200, 290], [200, 200]], "modifiers": ["ctrl"]})");
  const std::vector<Pin> all = pins(studio);
  ASSERT_GT(all.size(), 10u);
  ASSERT_LE(all.size(), 32u);
  double nearest = 10;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto pixel = pixel_of(studio.view().screen(), all[i].place);
    EXPECT_TRUE(pixel->y > 200 && pixel->y < 290) << pixel->y;
    for (std::size_t j = 0; j < i; ++j) nearest = std::min(nearest, norm(all[i].place - all[j].place));
  }
  const double area = 2 * std::numbers::pi * (0.5 - 0.05);  // of the zone
  EXPECT_GT(nearest, 0.5 * std::sqrt(area / static_cast<double>(all.size())));
  EXPECT_TRUE(std::ranges::any_of(all, [](const Pin& pin) { return pin.place.z < -0.5; })) << "also behind";
  EXPECT_TRUE(studio.document().shown().history.empty());
  run(studio, R"({"drag": [[395, 240], [405, 240], [405, 250], [395, 240]], "modifiers": ["ctrl"]})");
  EXPECT_LE(pins(studio).size(), all.size() + 2) << "little room is left";
}

TEST_F(PinsTest, APinBehindTheShapeIsNotTakenHoldOf) {
  Studio studio(options());
  run(studio, ball() + R"({"tool": "pins"}
{"click": [0.2, 0.1, 0.97]}
{"view": {"yaw_deg": 180}}
{"move": [0.2, 0.1, 0.97]}
)");
  EXPECT_FALSE(studio.pointed_pin());
  run(studio, R"({"click": [0.2, 0.1, 0.97]})");
  ASSERT_EQ(pins(studio).size(), 2u);
  EXPECT_LT(pins(studio)[1].place.z, -0.9);
  EXPECT_EQ(studio.pointed_pin(), 1u);
}

TEST_F(PinsTest, TheRadiusIsAutomaticUntilItIsSet) {
  Studio studio(options());
  run(studio, three_pins());
  const double automatic = studio.tools().radius();
  EXPECT_GT(automatic, 1) << "twice the distance of the farther of two others";
  run(studio, R"({"move": [400, 300]}
{"key": "F"}
{"move": [440, 300]})");
  EXPECT_FALSE(studio.tools().settings().auto_radius);
  EXPECT_NEAR(studio.tools().radius(), automatic + 0.2, 1e-9) << "it begins with the automatic one";
  run(studio, R"({"key": "Escape"})");
  EXPECT_TRUE(studio.tools().settings().auto_radius);
  EXPECT_EQ(studio.tools().radius(), automatic);
  run(studio, R"({"key": "["}
{"drag": [[0.5, 0, 0.866], [0.6, 0, 0.866]]})");
  EXPECT_FALSE(last_stroke(studio).radius_auto);
  EXPECT_LT(*last_stroke(studio).radius, automatic);
  EXPECT_EQ(*last_stroke(studio).radius, studio.tools().radius());
}

TEST_F(PinsTest, OnePinHasTheRadiusOfTheToolOrMore) {
  Studio studio(options());
  run(studio, ball() + R"({"tool": "pins"}
{"set": {"radius": 0.5}}
{"drag": [[0, 0, 1], [0.1, 0, 1]]})");
  EXPECT_EQ(*last_stroke(studio).radius, 0.5);
  run(studio, R"({"drag": [[0.1, 0, 1], [0.6, 0, 1]]})");
  const PinsStroke stroke = last_stroke(studio);
  EXPECT_DOUBLE_EQ(*stroke.radius, 2 * norm(stroke.to[0] - stroke.points[0]));
  EXPECT_GT(*stroke.radius, 0.9);
}

TEST_F(PinsTest, APinIsMovedByItsNumbers) {
  Studio studio(options());
  run(studio, three_pins());
  const Vec3d to = pins(studio)[1].place + Vec3d{0.1, 0.05, 0.2};
  studio.move_pin(1, to);
  run(studio, R"({"wait": true})");
  const PinsStroke stroke = last_stroke(studio);
  EXPECT_EQ(stroke.to[1], to);
  EXPECT_EQ(stroke.to[0], stroke.points[0]);
  EXPECT_LE(norm(pins(studio)[1].place - to), slack(studio));
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(pins(studio)[1].place, stroke.points[1]);
}

TEST_F(PinsTest, PinsThatMeetAreRefusedAndStayOnTheShape) {
  Studio studio(options());
  run(studio, three_pins());
  const std::vector<Pin> before = pins(studio);
  const std::vector<Vec3d> shape = positions(studio);
  studio.move_pin(1, before[0].place);
  run(studio, R"({"wait": true})");
  const std::string told = errors(studio);
  EXPECT_NE(told.find("Pins 0 and 1 meet"), std::string::npos) << told;
  EXPECT_TRUE(positions(studio) == shape);
  for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(pins(studio)[i].place, before[i].place);
}

TEST_F(PinsTest, TheInfluenceIsWhatThePinTakesAlong) {
  Studio studio(options());
  run(studio, three_pins() + R"({"show": {"influence": true}}
{"move": [0.5, 0, 0.866]}
)");
  Overlay overlay;
  const auto shades = overlay.influence(studio);
  ASSERT_TRUE(shades);
  const std::vector<Vec3d> now = positions(studio);
  const auto shade_at = [&](const Vec3d& p) {
    return (*shades)[static_cast<std::size_t>(std::ranges::find(now, p) - now.begin())];
  };
  EXPECT_GT(shade_at(pins(studio)[1].place), 0.99);
  EXPECT_LT(shade_at(pins(studio)[0].place), 0.01);
  EXPECT_LT(shade_at(pins(studio)[2].place), 0.01);
  EXPECT_FALSE(overlay.influence(studio)) << "nothing has changed";
  run(studio, R"({"move": [-0.4, 0, 0.917]})");
  EXPECT_TRUE(overlay.influence(studio));
}

TEST_F(PinsTest, AnOldDragHasAHandleAtItsEnd) {
  Studio studio(options());
  run(studio, three_pins() + R"({"drag": [[0.5, 0, 0.866], [0.8, 0.1, 0.866]]}
{"layer": 0, "select": true}
)");
  const PinsStroke before = last_stroke(studio);
  ASSERT_EQ(studio.history().editor().paths.size(), 1u);
  EXPECT_EQ(studio.history().editor().paths[0].points, (std::vector<Vec3d>{before.points[1], before.to[1]}));
  const auto end = pixel_of(studio.view().screen(), before.to[1]);
  run(studio, fmt::format(R"({{"drag": [[{}, {}], [{}, {}]]}})", end->x, end->y, end->x, end->y - 20));
  const PinsStroke after = last_stroke(studio);
  EXPECT_EQ(after.points, before.points);
  EXPECT_NEAR(after.to[1].y - before.to[1].y, 0.1, 0.02);
  EXPECT_EQ(after.to[0], before.to[0]);
  EXPECT_EQ(studio.document().shown().history.size(), 1u);
}

}  // namespace
}  // namespace knead::studio::pins_test
