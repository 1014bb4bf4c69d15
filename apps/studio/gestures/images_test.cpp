// Images of what a tool does, the lasso, the pen, and how the view follows the pointer.
#include "gestures/gesture.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gestures/gestures_fixture.h"
#include "view/overlay.h"

namespace knead::studio::images_test {
namespace {

// --- images ----------------------------------------------------------------------------------------------------------

TEST_F(GesturesTest, MirroredStampsAreDrawn) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "stamp"}
{"stamp": "letter-y"}
{"click": [0.5, 0.3, 0.81]}
{"move": [10, 10]})");
  const auto centers = [&] {
    Overlay overlay;
    std::vector<double> xs;
    for (const render::TranslucentSurface& surface : overlay.scene(studio).surfaces) {
      if (surface.mesh.positions.size() > 4) xs.push_back(bounding_box(surface.mesh.positions).center().x);
    }
    return xs;
  };
  ASSERT_EQ(centers().size(), 1u);
  const double x = centers().front();
  EXPECT_GT(x, 0.3);
  run(studio, R"({"set": {"mirror": [true, false, false], "drag": "normal"}})");
  ASSERT_EQ(centers().size(), 2u);
  EXPECT_NEAR(centers()[1], -x, 1e-9);
  const auto at = pixel_of(studio.view().screen(), studio.tools().placed().placement->center);
  run(studio, fmt::format(R"({{"press": [{0}, {1}]}}
{{"move": [{2}, {1}]}})",
                          at->x, at->y, at->x - 20));
  std::vector<double> pressed = centers();
  EXPECT_TRUE(std::ranges::any_of(pressed, [](double c) { return c < -0.3; })) << "in the drag as well";
}

TEST_F(GesturesTest, RadialStrokesAreTurnedAboutTheAxis) {
  Studio studio(options());
  run(studio, ball(10242));
  run(studio, R"({"set": {"radial": 8, "radial_axis": [0, 2, 0], "radius": 0.2}}
{"tool": "ball"}
{"drag": [[0.4, 0, 0.9], [0.5, 0.1, 0.9]], "steps": 1})");
  const std::vector<Stroke> strokes = last_strokes(studio);
  ASSERT_EQ(strokes.size(), 8u);
  const auto& first = std::get<ImplicitStroke>(strokes[0]);
  for (int k = 1; k < 8; ++k) {
    const RigidMotion turn = rotation_about({0, 0, 0}, {0, 1, 0}, 2 * std::numbers::pi * k / 8);
    const auto& image = std::get<ImplicitStroke>(strokes[static_cast<std::size_t>(k)]);
    for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(norm(image.path[i] - turn(first.path[i])), 1e-12);
  }
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
}

TEST_F(GesturesTest, OnTheAxisOrInThePlaneAStrokeIsDoneOnce) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"set": {"radial": 8, "radial_axis": [0, 0, 1], "start": "surface"}}
{"tool": "ball"}
{"set": {"drag": "axis", "axis": [0.1, 0, 1]}}
{"drag": [[402, 301], [402, 240]], "steps": 3})");
  ASSERT_EQ(last_strokes(studio).size(), 1u);
  const auto pull = std::get<ImplicitStroke>(last_strokes(studio).front());
  for (const Vec3d& p : pull.path) {
    EXPECT_EQ(std::hypot(p.x, p.y), 0) << "a pull on the axis stays on it";
  }
  run(studio, R"({"set": {"radial": 1, "drag": "view", "mirror_plane": {"point": [0, 0, 0], "normal": [1, 1, 0]}}}
{"drag": [[-0.6, 0.6, 0.5], [-0.7, 0.8, 0.5]], "steps": 1})");
  ASSERT_EQ(last_strokes(studio).size(), 1u);
  run(studio, R"({"drag": [[0.6, 0.1, 0.7], [0.7, 0.3, 0.7]], "steps": 1})");
  const std::vector<SessionStroke>& lines = studio.document().shown().history.back()->strokes;
  ASSERT_EQ(lines.size(), 1u) << "the image acts at the same time";
  ASSERT_EQ(lines.front().mirror.size(), 1u);
  EXPECT_LT(norm(cross(lines.front().mirror.front().normal, Vec3d{1, 1, 0})), 1e-12);
  EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
}

TEST_F(GesturesTest, APullAlongTheMirrorGoesInItWhereItsDashedRingReachesIt) {
  Studio studio(options());
  run(studio, ball(10242));
  run(studio, R"({"tool": "ball"}
{"view": {"yaw_deg": 0, "pitch_deg": 0}}
{"set": {"mirror": [true, false, false], "radius": 0.4, "inner_ratio": 0.35}})");
  const auto pulled = [&](const char* drag) {
    run(studio, drag);
    const auto stroke = std::get<ImplicitStroke>(last_strokes(studio).front());
    EXPECT_GT(norm(stroke.path.back() - stroke.path.front()), 0.2);
    EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
    run(studio, R"({"key": "Ctrl+Z"})");
    return stroke.path;
  };
  const auto is_in_plane = [](const Vec3d& p) { return p.x == 0; };
  EXPECT_TRUE(std::ranges::all_of(pulled(R"({"drag": [[0.2, 0, 0.98], [0.3, 0.3, 0.98]]})"), is_in_plane));
  EXPECT_TRUE(std::ranges::none_of(pulled(R"({"drag": [[0.2, 0, 0.98], [0.5, 0.1, 0.98]]})"), is_in_plane))
      << "two pulls away from each other";
  EXPECT_TRUE(std::ranges::none_of(pulled(R"({"drag": [[0.32, 0, 0.947], [0.4, 0.3, 0.947]]})"), is_in_plane));
  EXPECT_TRUE(std::ranges::all_of(pulled(R"({"drag": [[0.05, 0, 0.99], [0.5, 0.25, 0.99]]})"), is_in_plane))
      << "so near to the plane in every direction";
}

TEST_F(GesturesTest, AMirrorGoesThroughTheMiddleAFaceOrThreePoints) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"tool": "ball"})");
  studio.tools().pick_mirror(StudioTools::PlanePick::face);
  run(studio, R"({"click": [0, 0, 1]})");
  ASSERT_TRUE(studio.tools().settings().symmetry.plane);
  EXPECT_GT(studio.tools().settings().symmetry.plane->normal.z, 0.99);
  EXPECT_NEAR(studio.tools().settings().symmetry.plane->point.z, 1, 0.01);
  EXPECT_TRUE(studio.document().shown().history.empty()) << "the click is for the plane alone";
  studio.tools().pick_mirror(StudioTools::PlanePick::three_points);
  run(studio, R"({"click": [0, 0.5, 0.86]}
{"click": [0, -0.5, 0.86]}
{"click": [0, 0.5, 0.86]})");
  EXPECT_NE(errors(studio).find("on a line"), std::string::npos);
  run(studio, R"({"click": [0, 0, 1]})");
  EXPECT_EQ(studio.tools().picking_mirror(), StudioTools::PlanePick::none);
  EXPECT_NEAR(std::abs(studio.tools().settings().symmetry.plane->normal.x), 1, 0.01);
  run(studio, R"({"drag": [[0.5, 0, 0.86], [0.6, 0.1, 0.86]]})");
  EXPECT_EQ(studio.document().shown().history.size(), 1u);
  studio.tools().settings().symmetry.plane.reset();
  studio.tools().center_symmetry();
  EXPECT_LT(norm(studio.tools().settings().symmetry.center - bounding_box(positions(studio)).center()), 1e-12);
}

// --- the pen, the view -----------------------------------------------------------------------------------------------

TEST_F(GesturesTest, APenChangesRadiusOrDepthOrNothing) {
  const auto painted = [&](PenPressure use, const char* pressure) {
    Studio studio(options());
    studio.preferences().pressure = use;
    run(studio, ball(10242));
    run(studio, std::string(R"({"tool": "paint"}
{"set": {"radius": 0.5}}
{"drag": [[-0.5, 0, 0.86], [0.5, 0, 0.86]], "pressure": )") +
                    pressure + "}");
    double most = 0;
    for (const Vec3d& p : positions(studio)) most = std::max(most, norm(p) - 1);
    EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == positions(studio));
    return std::pair{most, last_strokes(studio)};
  };
  const double full = painted(PenPressure::depth, "[1, 1]").first;
  EXPECT_NEAR(painted(PenPressure::none, "[0.3, 0.3]").first, full, 1e-9);
  EXPECT_NEAR(painted(PenPressure::depth, "[0.5, 0.5]").first, 0.5 * full, 0.15 * full);
  const auto [height, half] = painted(PenPressure::radius, "[0.5, 0.5]");
  ASSERT_EQ(half.size(), 1u);
  EXPECT_NEAR(std::get<PaintStroke>(half.front()).bump, 0.25, 1e-12);
  EXPECT_NEAR(height, 0.5 * full, 0.15 * full) << "the depth is relative to the radius";
  const std::vector<Stroke> growing = painted(PenPressure::radius, "[0.25, 1]").second;
  EXPECT_GT(growing.size(), 4u);
  for (std::size_t i = 1; i < growing.size(); ++i) {
    EXPECT_GT(std::get<PaintStroke>(growing[i]).bump, std::get<PaintStroke>(growing[i - 1]).bump);
  }
}

TEST_F(GesturesTest, TheViewTurnsAboutThePointUnderThePointer) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"view": {"yaw_deg": 0, "pitch_deg": 0}})");
  const Vec3d point{0.6, 0.3, 0.74};
  const auto before = pixel_of(studio.view().screen(), point);
  const auto hit = studio.document().shown().picker->pick(ray_through(studio.view().screen(), before->x, before->y),
                                                          studio.document().shown().state);
  ASSERT_TRUE(hit);
  run(studio, fmt::format(R"({{"drag": [[{0}, {1}], [{2}, {3}]], "button": "middle"}})", before->x, before->y,
                          before->x + 90, before->y + 40));
  EXPECT_GT(std::abs(studio.view().navigation().view.yaw), 0.2);
  const auto after = pixel_of(studio.view().screen(), hit->point);
  EXPECT_NEAR(after->x, before->x, 1e-6);
  EXPECT_NEAR(after->y, before->y, 1e-6);
  // Beside the shape about the middle of the view.
  const Vec3d target = studio.view().navigation().view.target;
  run(studio, R"({"drag": [[20, 20], [120, 20]], "button": "middle"})");
  EXPECT_LT(norm(studio.view().navigation().view.target - target), 1e-12);
}

TEST_F(GesturesTest, TheLastStrokeIsFramed) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"set": {"radius": 0.1}}
{"tool": "ball"}
{"drag": [[0.7, 0, 0.7], [0.8, 0, 0.7]]}
{"key": "Numpad ."})");
  const View& view = studio.view().navigation().view;
  EXPECT_LT(view.height, 1);
  EXPECT_NEAR(view.target.x, 0.73, 0.1);
  run(studio, R"({"key": "Home"})");
  EXPECT_GT(studio.view().navigation().view.height, 2);
  // What is placed comes before that.
  run(studio, R"({"tool": "stamp"}
{"click": [-0.7, 0, 0.7]}
{"key": "."})");
  EXPECT_LT(studio.view().navigation().view.height, 2.5);
  EXPECT_LT(studio.view().navigation().view.target.x, -0.5);
}

}  // namespace
}  // namespace knead::studio::images_test
