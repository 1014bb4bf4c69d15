// Gestures by the events of a pointer: depth, hints, pulls, the cursor, numbers and snapping.
#include "gestures/gesture.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "document/layers.h"
#include "gestures/gestures_fixture.h"
#include "knead/mesh.h"
#include "view/overlay.h"

namespace knead::studio::gestures_test {
namespace {

// --- beside the shape ------------------------------------------------------------------------------------------------

// The ball ends at 200 pixels from the middle, and the tool is 100 wide.
TEST_F(GesturesTest, ADragThatBeginsBesideTheShapeTurnsTheView) {
  for (const char* tool : {"ball", "capsule", "paint"}) {
    Studio studio(options());
    run(studio, ball() + fmt::format(R"({{"tool": "{}"}})", tool));
    const View before = studio.view().navigation().view;
    run(studio, R"({"drag": [[720, 300], [760, 330]]})");
    EXPECT_EQ(studio.document().shown().history.size(), 0u) << tool;
    EXPECT_NEAR(std::abs(studio.view().navigation().view.yaw - before.yaw), 40 * std::numbers::pi / 600, 1e-9) << tool;
    EXPECT_EQ(studio.view().navigation().drag, NavigationDrag::none) << "the drag has ended";

    const View turned = studio.view().navigation().view;
    run(studio, R"({"drag": [[620, 300], [590, 300], [560, 300]]})");
    EXPECT_EQ(studio.document().shown().history.size(), 1u) << tool;  // paint begins where it meets the shape
    EXPECT_EQ(studio.view().navigation().view.yaw, turned.yaw) << tool;
  }
}

// A stamp that is placed, and its gizmo, are taken hold of; a press beside them and the shape turns the view.
TEST_F(GesturesTest, ADragBesideTheShapeTurnsTheViewWithWhatIsPlacedOnTheShape) {
  for (const char* tool : {"stamp", "points", "curve", "inflate", "mask"}) {
    Studio studio(options());
    run(studio, ball() + fmt::format(R"({{"tool": "{}"}})", tool));
    if (std::string_view(tool) == "stamp" || std::string_view(tool) == "points") {
      run(studio, R"({"click": [0, 0, 1]})");
    }
    const View before = studio.view().navigation().view;
    run(studio, R"({"drag": [[720, 300], [760, 330]]})");
    EXPECT_NEAR(std::abs(studio.view().navigation().view.yaw - before.yaw), 40 * std::numbers::pi / 600, 1e-9) << tool;
    EXPECT_EQ(studio.document().shown().history.size(), 0u) << tool;
    EXPECT_EQ(studio.tools().placed().placement.has_value(), std::string_view(tool) == "stamp");
  }
}

// --- depth -----------------------------------------------------------------------------------------------------------

TEST_F(GesturesTest, AStampThatFacesTheViewerGoesInByVerticalMovement) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "stamp"}
{"click": [0, 0, 1]}
{"move": [400, 300]})");
  ASSERT_TRUE(studio.tools().placed().placement);
  const Vec3d before = studio.tools().placed().placement->center;
  const auto arrow = in_arrow(studio);
  ASSERT_TRUE(arrow) << "where to move the pointer is shown before the drag";
  const auto from = pixel_of(studio.view().screen(), arrow->from);
  const auto to = pixel_of(studio.view().screen(), arrow->to);
  const double in = to->y < from->y ? -1 : 1;  // of the pointer's y
  run(studio, R"({"drag": [[400, 300], [400, )" + std::to_string(300 + in * 40) + "]]}");
  const Vec3d after = studio.tools().placed().placement->center;
  EXPECT_NEAR(after.x, before.x, 1e-6);
  EXPECT_NEAR(after.y, before.y, 1e-6);
  EXPECT_NEAR(after.z, before.z - 40 * pixel_size(studio.view().screen(), before), 1e-3);

  const std::vector<SessionStroke> strokes = studio.document().shown().history.back()->strokes;
  EXPECT_EQ(words_of(strokes, ""), fmt::format("Stamp {:.2g}", before.z - after.z)) << "of all its pieces";
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_EQ(studio.tools().placed().placement->center, before) << "not left within the shape";
}

TEST_F(GesturesTest, DownIsInWhereverAFaceThatIsLookedAtIsStamped) {
  for (const char* view : {"Alt+1", "Ctrl+Alt+1", "Alt+3", "Alt+7", "Ctrl+Alt+7", "Home"}) {
    for (const int y : {-100, 0, 100}) {  // pixels from the middle of a ball of radius 200: up to 30 degrees
      Studio studio(options());
      run(studio, ball());
      run(studio, fmt::format(R"({{"view": {{"yaw_deg": 30, "pitch_deg": 25}}}}
{{"key": "{0}"}}
{{"view": {{"target": [0, 0, 0], "height": 3}}}}
{{"tool": "stamp"}}
{{"set": {{"radius": 0.2}}}}
{{"click": [410, {1}]}}
{{"move": [410, {1}]}})",
                              view, 300 + y));
      const auto arrow = in_arrow(studio);
      ASSERT_TRUE(arrow) << view << ' ' << y;
      EXPECT_GT(pixel_of(studio.view().screen(), arrow->to)->y, pixel_of(studio.view().screen(), arrow->from)->y);
      if (y < 100) continue;
      const Vec3d before = studio.tools().placed().placement->center;
      const auto at = pixel_of(studio.view().screen(), before);
      run(studio, fmt::format(R"({{"drag": [[{0}, {1}], [{0}, {2}]], "steps": 1}})", at->x, at->y, at->y + 10));
      const Vec3d after = studio.tools().placed().placement->center;
      EXPECT_LT(norm(after), norm(before)) << view << ' ' << y;
    }
  }
}

// A drag is applied in pieces. Their print is that of one stroke: no triangles cross, and the volume stays.
TEST_F(GesturesTest, AStampThatIsDraggedInSlipsUnlessItIsToStick) {
  Studio studio(options());
  run(studio, ball(40000));
  run(studio, R"({"tool": "stamp"}
{"stamp": "letter-y"}
{"set": {"radius": 0.8}}
{"click": [0, 0, 1]}
{"move": [400, 300]})");
  ASSERT_TRUE(studio.tools().placed().placement);
  const double volume = measure(studio.document().shown().state.to_mesh()).volume;
  const auto arrow = in_arrow(studio);
  ASSERT_TRUE(arrow);
  const double in =
      pixel_of(studio.view().screen(), arrow->to)->y < pixel_of(studio.view().screen(), arrow->from)->y ? -1 : 1;
  const double pixels = 0.2 / pixel_size(studio.view().screen(), studio.tools().placed().placement->center);
  run(studio, fmt::format(R"({{"drag": [[400, 300], [400, {}]], "steps": 30}})", 300 + in * pixels));
  const std::vector<Stroke> pieces = last_strokes(studio);
  EXPECT_GT(pieces.size(), 5u);
  for (const Stroke& piece : pieces) {
    EXPECT_EQ(contact_of(std::get<StampStroke>(piece)), StampContact::slip);
    EXPECT_FALSE(std::get<StampStroke>(piece).outer);
  }
  const Mesh printed = studio.document().shown().state.to_mesh();
  EXPECT_EQ(self_intersections(triangulate(printed), printed.positions).count, 0u);
  EXPECT_NEAR(measure(printed).volume, volume, 1e-4 * volume);
  run(studio, R"({"set": {"contact": "stick"}})");
  const StampStroke sticking =
      stamp_at(studio.tools().settings(), *studio.tools().placed().stamp, *studio.tools().placed().placement);
  EXPECT_EQ(sticking.contact, StampContact::stick);
  EXPECT_DOUBLE_EQ(sticking.outer.value_or(0), 1.5 * 0.5 * 0.8);
}

TEST_F(GesturesTest, ADragAlongALineFollowsThePointerWithinBoundsAtEveryAngle) {
  Studio studio(options());
  run(studio, ball());
  ToolSettings settings;
  settings.drag = DragMode::axis;
  const ShapeState& state = studio.document().shown().state;
  const double pixel = pixel_size(studio.view().screen(), {0, 0, 0});
  double before = 0;
  for (int i = 0; i <= 900; ++i) {
    const double angle = i * std::numbers::pi / 1800;  // from the view to upright in the picture
    settings.axis = {0, std::sin(angle), std::cos(angle)};
    const GestureContext around{studio.view().screen(), state, nullptr, settings};
    const Drag drag = begin_drag({400, 300}, {0, 0, 0}, {0, 0, 1}, around);
    const double along = drag.length_of(drag.at({400, 290}, around)) / (10 * pixel);
    EXPECT_GT(along, 0.9) << "upwards is along the axis at " << i / 10.0;
    EXPECT_LT(along, 3) << "at " << i / 10.0;
    EXPECT_NEAR(along, i == 0 ? along : before, 0.03) << "at " << i / 10.0;
    before = along;
    EXPECT_EQ(drag.at({400, 300}, around), drag.start);
  }
  EXPECT_NEAR(before, 1, 0.01) << "seen from the side, the point stays under the pointer";
}

// --- inflate: a line on the surface, and then the shape grows --------------------------------------------------------

double volume_of(const Studio& studio) { return measure(studio.document().shown().state.to_mesh()).volume; }

constexpr const char* kInflate = R"({"tool": "inflate"}
{"set": {"radius": 0.5, "depth": 0.2}}
)";

double most_moved(const std::vector<Vec3d>& before, const std::vector<Vec3d>& after) {
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) most = std::max(most, norm(after[i] - before[i]));
  return most;
}

TEST_F(GesturesTest, AnInflatedShapeRisesByTheDepthThatIsSetAndNothingBeyondTheRadiusMoves) {
  Studio studio(options());
  run(studio, ball() + kInflate);
  const std::vector<Vec3d> start = positions(studio);
  const double before = volume_of(studio);
  run(studio, R"({"drag": [[0, 0, 1], [0.3, 0, 0.95]]})");
  ASSERT_EQ(studio.document().shown().history.size(), 1u);
  EXPECT_EQ(errors(studio), "");
  const std::vector<Vec3d> now = positions(studio);
  EXPECT_NEAR(most_moved(start, now), 0.1, 1e-3);
  EXPECT_GT(volume_of(studio), before);
  const InflateStroke stroke = std::get<InflateStroke>(last_strokes(studio).front());
  EXPECT_GT(stroke.points.size(), 1u);
  EXPECT_EQ(words_of(studio.document().shown().history.back()->strokes, "mm"), "Inflate by 0.1 mm");
  for (std::size_t i = 0; i < start.size(); ++i) {
    const bool is_far = std::all_of(stroke.points.begin(), stroke.points.end(),
                                    [&](const Vec3d& p) { return norm(p - start[i]) > 0.5; });
    EXPECT_TRUE(!is_far || now[i] == start[i]);
  }
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
}

TEST_F(GesturesTest, InflateShrinksWithCtrlAndTakesATypedDepth) {
  Studio studio(options());
  run(studio, ball() + kInflate);
  const std::vector<Vec3d> start = positions(studio);
  const double before = volume_of(studio);
  run(studio, R"({"drag": [[0, 0, 1], [0.2, 0, 0.97]], "modifiers": ["ctrl"]})");
  EXPECT_NEAR(most_moved(start, positions(studio)), 0.1, 1e-3);
  EXPECT_LT(volume_of(studio), before);
  run(studio, R"({"key": "Ctrl+Z"}
{"press": [0, 0, 1]}
{"key": "."}
{"key": "2"})");
  EXPECT_EQ(numbers_at_pointer(studio).front(), "Distance .2_");
  run(studio, R"({"release": [0, 0, 1]})");
  EXPECT_NEAR(most_moved(start, positions(studio)), 0.2, 2e-3);
  EXPECT_GT(volume_of(studio), before);
  run(studio, R"({"key": "Ctrl+Z"}
{"key": "I"}
{"click": [0, 0, 1]})");
  EXPECT_LT(volume_of(studio), before) << "\"Shrink\" is set";
}

TEST_F(GesturesTest, AnInflatedShapeWithAMirrorGrowsOnBothSides) {
  Studio studio(options());
  run(studio, ball() + kInflate + R"({"set": {"mirror": [true, false, false]}}
{"click": [0.7, 0, 0.7]})");
  EXPECT_EQ(errors(studio), "");
  const std::vector<Vec3d> after = positions(studio);
  const auto farthest = [&](double side) {
    double most = 0;
    for (const Vec3d& p : after) {
      if (p.x * side > 0) most = std::max(most, norm(p));
    }
    return most;
  };
  EXPECT_GT(farthest(1), 1.03);
  EXPECT_NEAR(farthest(1), farthest(-1), 0.01);
}

// --- hints -----------------------------------------------------------------------------------------------------------

TEST_F(GesturesTest, TheHintOfATurnIsWhatTurnsIt) {
  for (const char* tool : {"bend", "twist", "rotate"}) {
    Studio studio(options());
    run(studio, ball());
    run(studio, std::string(R"({"set": {"limit_cylinder": false}}
{"tool": ")") + tool +
                    R"("}
{"click": [0, 0, 1]})");
    const auto hint = [&] {
      const TurnDrag turning = turn_drag(studio.view().screen(), studio.tools().settings(), studio.tools().placed());
      return std::pair{turning, hint_of(studio.tools().settings(), studio.tools().placed(), turning)};
    };
    const auto amount_by = [&](const char* places) {
      run(studio, R"({"press": [600, 300]}
{"move": )" + std::string(places) +
                      "}");
      const double amount = std::get<TurnGesture>(studio.gesture()->kind).amount;
      run(studio, R"({"key": "Escape"})");
      return amount;
    };
    const bool faces = std::string(tool) != "twist";
    EXPECT_EQ(hint().first, faces ? TurnDrag::round : TurnDrag::sideways) << tool;
    EXPECT_NE(hint().second.find(faces ? "round its middle" : "right or left"), std::string::npos) << hint().second;
    if (faces) {
      EXPECT_EQ(amount_by("[700, 300]"), 0) << tool << ": straight away from the middle nothing turns";
      EXPECT_NE(amount_by("[600, 200]"), 0) << tool;
    } else {
      EXPECT_NE(amount_by("[700, 300]"), 0) << tool;
    }
    // From the side the axes of bend and rotate lie level in the picture.
    if (!faces) continue;
    run(studio, R"({"view": {"yaw_deg": 90}})");
    EXPECT_EQ(hint().first, TurnDrag::upright) << tool;
    EXPECT_NE(hint().second.find("up or down"), std::string::npos) << hint().second;
    EXPECT_NE(amount_by("[600, 200]"), 0) << tool;
  }
}

TEST_F(GesturesTest, ABendGoesBeyondWhatAPlainOneCan) {
  Studio studio(options());
  Mesh bar = make_shape(ShapeKind::box, 4000);
  for (Vec3d& p : bar.positions) p.x *= 2;
  const std::string file = (folder_ / "bar.ply").string();
  write_mesh(file, bar);
  run(studio, R"({"size": [800, 600]}
{"open": ")" + file +
                  R"("}
{"wait": true}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 6}}
{"tool": "bend"}
{"click": [0.6, 0, 0.5]}
{"press": [600, 300]}
{"key": "1"}
{"key": "7"}
{"key": "5"})");
  ASSERT_TRUE(studio.gesture());
  StretchEstimate estimate;
  EXPECT_NO_THROW(estimate.update(studio));
  run(studio, R"({"key": "Enter"})");
  const auto stroke = std::get<BendStroke>(last_strokes(studio).front());
  EXPECT_NEAR(std::abs(stroke.angle_deg), 175, 1e-9);
  const Mesh mesh = *studio.document().shown().state.mesh;
  Mesh moved = mesh;
  moved.positions = positions(studio);
  EXPECT_NE(moved.positions, mesh.positions);
  EXPECT_NEAR(measure(moved).volume / measure(mesh).volume, 1, 3e-3);
  EXPECT_EQ(self_intersections(triangulate(moved), moved.positions).count, 0U);
}

// --- pull ------------------------------------------------------------------------------------------------------------

TEST_F(GesturesTest, APullHasARoundEndUnlessAFlatOneIsChosen) {
  const auto pulled = [&](const std::string& setting) {
    Studio studio(options());
    run(studio, ball(10242) + setting);
    run(studio, R"({"tool": "ball"}
{"set": {"drag": "axis", "axis": [0, 0, 1]}}
{"press": [400, 300]}
{"key": "."}
{"key": "6"}
{"key": "Enter"})");
    const auto stroke = std::get<ImplicitStroke>(last_strokes(studio).front());
    // How wide the end is, a little below its tip.
    const std::vector<Vec3d> after = positions(studio);
    double tip = 0;
    for (const Vec3d& p : after) tip = std::max(tip, p.z);
    double wide = 0;
    for (const Vec3d& p : after) {
      if (p.z > tip - 0.03) wide = std::max(wide, std::hypot(p.x, p.y));
    }
    return std::pair{norm(stroke.path.front()), wide};
  };
  const auto [round_start, round_end] = pulled("");
  const auto [flat_start, flat_end] = pulled(R"({"set": {"start": "surface"}})");
  EXPECT_NEAR(flat_start, 1, 0.02);
  EXPECT_NEAR(round_start, 1 - 0.4 * 0.5, 0.02);
  EXPECT_GT(flat_end, 0.18) << "a disc as wide as the inner region";
  EXPECT_LT(round_end, 0.85 * flat_end);
}

TEST_F(GesturesTest, InAThinShapeARoundEndBeginsHalfWayThrough) {
  Studio studio(options());
  run(studio, R"({"size": [800, 600]}
{"new": "box"}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 6}}
{"tool": "ball"}
{"set": {"radius": 4, "inner_ratio": 0.9}}
{"drag": [[400, 300], [420, 300]], "steps": 1})");
  const auto stroke = std::get<ImplicitStroke>(last_strokes(studio).front());
  const Box box = bounding_box(studio.document().shown().state.mesh->positions);
  EXPECT_NEAR(stroke.path.front().z, box.center().z, 1e-9);
}

// --- the cursor ------------------------------------------------------------------------------------------------------

TEST_F(GesturesTest, TheCursorHasASolidRingAndADashedOneAndRegionsAreShownOnDemand) {
  Studio studio(options());
  run(studio, ball(10242));
  run(studio, R"({"tool": "ball"}
{"move": [0.3, 0.3, 0.9]})");
  Overlay overlay;
  const render::LiveScene scene = overlay.scene(studio);
  EXPECT_TRUE(scene.surfaces.empty()) << "regions are shown on demand only";
  ASSERT_EQ(scene.lines.size(), 17u);
  const render::Color outer = studio.preferences().outer_ring;
  for (const render::Line& line : scene.lines) {
    const bool is_outer = line.color == outer;
    EXPECT_EQ(line.closed, is_outer);
    EXPECT_EQ(line.points.size(), is_outer ? 64u : 3u);
  }
  run(studio, R"({"set": {"mirror": [true, false, false], "radial": 3}})");
  EXPECT_EQ(overlay.scene(studio).lines.size(), scene.lines.size() + 5 + 1) << "five dots, and the axis";
  run(studio, R"({"show": {"region": true}})");
  EXPECT_GT(overlay.scene(studio).surfaces.size(), 1u);
}

TEST_F(GesturesTest, BetweenTwoFingersTheCursorIsOneRing) {
  Studio studio(options());
  run(studio, R"({"size": [800, 600]}
{"new": "hand", "vertices": 6000}
{"tool": "ball"}
{"key": "Alt+1"})");
  studio.tools().settings().radius = 0.3;
  const render::Color outer = studio.preferences().outer_ring;
  Overlay overlay;
  for (double x = 300; x < 500; x += 10) {
    run(studio, fmt::format(R"({{"move": [{}, 200]}})", x));
    std::size_t pieces = 0;
    for (const render::Line& line : overlay.scene(studio).lines) pieces += line.color == outer ? 1 : 0;
    EXPECT_EQ(pieces, 1u) << x;
  }
}

TEST_F(GesturesTest, InADragTheCursorGoesWithTheToolAndRegionsFade) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"show": {"region": true}}
{"tool": "ball"}
{"move": [0, 0, 1]})");
  Overlay overlay;
  const float alpha = overlay.scene(studio).surfaces.front().color.alpha;
  run(studio, R"({"press": [400, 300]}
{"move": [480, 300]})");
  const render::LiveScene scene = overlay.scene(studio);
  EXPECT_NEAR(scene.surfaces.front().color.alpha, 0.4 * alpha, 1e-6);
  const auto& gesture = std::get<ImplicitGesture>(studio.gesture()->kind);
  const auto ring = std::ranges::find(scene.lines, studio.preferences().outer_ring, &render::Line::color);
  ASSERT_NE(ring, scene.lines.end());
  Vec3d middle{};
  for (const Vec3d& p : ring->points) middle += p * (1.0 / static_cast<double>(ring->points.size()));
  const Vec3d tool = gesture.touched + (gesture.stroke.path.back() - gesture.stroke.path.front());
  const auto seen = pixel_of(studio.view().screen(), middle);
  const auto wanted = pixel_of(studio.view().screen(), tool);
  ASSERT_TRUE(seen && wanted);
  EXPECT_NEAR(seen->x, wanted->x, 1e-6);
  EXPECT_NEAR(seen->y, wanted->y, 1e-6);
}

// --- numbers ---------------------------------------------------------------------------------------------------------

TEST_F(GesturesTest, ATypedDistanceIsTheDistance) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "ball"}
{"press": [400, 300]}
{"move": [430, 290]}
{"move": [460, 300]}
{"key": "4"}
{"key": "5"}
{"key": "Backspace"}
{"key": "Backspace"}
{"key": "Numpad 0"}
{"key": "."}
{"key": "3"}
{"key": "5"})");
  ASSERT_TRUE(studio.number());
  EXPECT_EQ(studio.number()->typed, "0.35");
  EXPECT_EQ(studio.tools().settings().tool->use, ToolUse::pull) << "digits choose no tool now";
  EXPECT_EQ(numbers_at_pointer(studio).front(), "Distance 0.35_");
  run(studio, R"({"key": "Enter"}
{"release": [460, 300]})");
  EXPECT_FALSE(studio.gesture());
  ASSERT_EQ(last_strokes(studio).size(), 1u);
  EXPECT_NEAR(length_of(last_strokes(studio).front()), 0.35, 1e-12);
  EXPECT_EQ(std::get<ImplicitStroke>(last_strokes(studio).front()).path.size(), 2u);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
}

TEST_F(GesturesTest, ATypedCommaIsADecimalPoint) {
  Studio studio(options());
  run(studio, ball());
  for (const char* comma : {",", "."}) {
    run(studio, R"({"tool": "ball"}
{"press": [400, 300]}
{"move": [460, 300]}
{"key": "0"}
{"key": ")" + std::string(comma) +
                    R"("}
{"key": "2"}
{"key": "5"}
{"key": "Enter"}
{"release": [460, 300]})");
    EXPECT_NEAR(length_of(last_strokes(studio).front()), 0.25, 1e-12) << comma;
  }
}

TEST_F(GesturesTest, MinusTurnsANumberRoundAndEscapeGivesUp) {
  Studio studio(options());
  run(studio, ball());
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"tool": "ball"}
{"set": {"drag": "axis", "axis": [1, 0, 0]}}
{"press": [400, 300]}
{"move": [460, 300]}
{"key": "."}
{"key": "2"}
{"key": "-"})");
  ASSERT_TRUE(studio.number());
  EXPECT_NEAR(studio.number()->amount.value, -0.2, 1e-12);
  EXPECT_FALSE(positions(studio) == before);
  run(studio, R"({"key": "Escape"}
{"release": [460, 300]})");
  EXPECT_TRUE(positions(studio) == before);
  EXPECT_TRUE(studio.document().shown().history.empty());
  EXPECT_FALSE(studio.number());
}

TEST_F(GesturesTest, AnglesPercentAndTheRadiusCanBeTyped) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "rotate"}
{"click": [0, 0, 1]}
{"press": [600, 300]}
{"key": "4"}
{"key": "5"}
{"key": "Enter"}
{"release": [600, 300]})");
  EXPECT_EQ(std::get<RotateStroke>(last_strokes(studio).front()).angle_deg, 45);
  run(studio, R"({"tool": "stretch"}
{"press": [600, 300]}
{"key": "5"}
{"key": "0"}
{"release": [600, 300]})");
  EXPECT_NEAR(std::get<StretchStroke>(last_strokes(studio).front()).factor, 1.5, 1e-12);
  run(studio, R"({"key": "F"}
{"key": "."}
{"key": "7"}
{"key": "Enter"})");
  EXPECT_EQ(studio.tools().settings().radius, 0.7);
  run(studio, R"({"key": "F"}
{"key": "2"}
{"key": "Escape"})");
  EXPECT_EQ(studio.tools().settings().radius, 0.7);
  EXPECT_FALSE(studio.number());
}

TEST_F(GesturesTest, CtrlSnapsDistancesAnglesAndTheGizmo) {
  EXPECT_EQ(snap_length(1), 0.01);
  EXPECT_EQ(snap_length(230), 2);
  EXPECT_EQ(snap_length(0.06), 0.0005);
  Studio studio(options());
  run(studio, ball());
  const double step = snap_length(studio.document().shown().diagonal);
  run(studio, R"({"tool": "ball"}
{"drag": [[400, 300], [437, 311]], "modifiers": ["ctrl"]})");
  const double steps = length_of(last_strokes(studio).front()) / step;
  EXPECT_GT(steps, 1);
  EXPECT_NEAR(steps, std::round(steps), 1e-9);
  run(studio, R"({"tool": "rotate"}
{"click": [0, 0, 1]}
{"drag": [[600, 300], [600, 225]], "modifiers": ["ctrl"]})");
  EXPECT_EQ(std::get<RotateStroke>(last_strokes(studio).front()).angle_deg, 15);
  const Vec3d before = studio.tools().placed().placement->center;
  const auto tip =
      pixel_of(studio.view().screen(),
               before + studio.tools().placed().placement->x *
                            (0.8 * gizmo_size(studio.view().screen(), *studio.tools().placed().placement)));
  run(studio,
      fmt::format(R"({{"drag": [[{0}, {1}], [{2}, {1}]], "modifiers": ["ctrl"]}})", tip->x, tip->y, tip->x + 33));
  const double moved = norm(studio.tools().placed().placement->center - before) / step;
  EXPECT_GT(moved, 1);
  EXPECT_NEAR(moved, std::round(moved), 1e-9);
}

TEST_F(GesturesTest, NumbersHaveTheUnitOfThePreferences) {
  Studio studio(options());
  run(studio, ball());
  studio.preferences().unit = LengthUnit::millimetre;
  EXPECT_TRUE(numbers_at_pointer(studio).empty());
  run(studio, R"({"tool": "ball"}
{"set": {"drag": "axis", "axis": [1, 0, 0]}}
{"press": [400, 300]}
{"move": [440, 300]}
{"key": "."}
{"key": "2"})");
  const std::vector<std::string> lines = numbers_at_pointer(studio);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0], "Distance .2_ mm");
  EXPECT_EQ(lines[1], "Radius 0.5 mm");
  EXPECT_EQ(lines[2].substr(0, 7), "Volume ");
  EXPECT_EQ(lines[2].back(), '%');
  EXPECT_EQ(text_of({AmountKind::length, 0.2}, LengthUnit::none), "0.2");
  EXPECT_EQ(text_of({AmountKind::percent, 12.34}, LengthUnit::metre), "12.3%");
}

}  // namespace
}  // namespace knead::studio::gestures_test
