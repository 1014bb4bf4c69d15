// Stretches: guards against thin zones, the colours, the offer to remesh.
#include "view/overlay.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "studio_fixture.h"

namespace knead::studio::stretch_test {
namespace {

// The cylinder of radius 0.5 about z from -3 to 3, seen from the side: 100 pixels a unit, the middle at (400, 300).
constexpr const char* kCylinder = R"({"size": [800, 600]}
{"new": "cylinder", "vertices": 20000}
{"view": {"yaw_deg": 0, "pitch_deg": 90, "target": [0, 0, 0], "height": 6}}
{"set": {"radius": 0.3, "inner_ratio": 0.4, "limit_cylinder": false}}
)";

double greatest(const std::vector<float>& values) { return *std::ranges::max_element(values); }

double stretch_since_start(const Studio& studio) {
  return greatest(stretches_shown(studio.document().shown(), StretchView::since_start).value());
}

const Stroke& last_stroke(const Studio& studio) {
  return studio.document().shown().history.back()->strokes.back().stroke;
}

class StretchTest : public StudioTest {
 protected:
  // A bend of the cylinder about its middle, across the view.
  static void bend_cylinder(Studio& studio, const std::string& first = "") {
    run(studio, std::string(kCylinder) + R"({"tool": "bend"}
{"set": {"radius": 0.3}}
)" + first + R"({"click": [400, 300]}
{"drag": [[400, 100], [560, 180]]})");
  }
};

TEST_F(StretchTest, ABendWidensAZoneThatIsTooThin) {
  Studio studio(options());
  bend_cylinder(studio);
  EXPECT_EQ(errors(studio), "");
  const auto& bend = std::get<BendStroke>(last_stroke(studio));
  const double width = std::get<BendWidth>(bend.extent).width;
  EXPECT_GT(std::abs(bend.angle_deg), 30);
  EXPECT_GT(width, 1.6 * std::abs(bend.angle_deg) * std::numbers::pi / 180 * 0.5);
  EXPECT_LT(stretch_since_start(studio), 4);
  EXPECT_TRUE(saved_and_replayed(studio).warnings.empty());
  studio.document().close();
}

TEST_F(StretchTest, AThinZoneCanBeKept) {
  Studio studio(options());
  bend_cylinder(studio, "{\"set\": {\"widens_zone\": false}}\n");
  const auto& bend = std::get<BendStroke>(last_stroke(studio));
  EXPECT_EQ(std::get<BendWidth>(bend.extent).width, 0.3);
  EXPECT_GT(stretch_since_start(studio), 6);
  const std::vector<std::string> warnings = saved_and_replayed(studio).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("too thin"), std::string::npos) << warnings[0];
  studio.document().close();
}

TEST_F(StretchTest, TheZoneGrowsWithTheAngleAndStudioSaysSo) {
  Studio studio(options());
  run(studio, kCylinder + std::string(R"({"tool": "bend"}
{"click": [400, 300]}
{"move": [400, 100]}
{"press": [400, 100]})"));
  double before = 0;
  for (const char* const to : {"[540, 157]", "[590, 240]", "[600, 300]"}) {
    run(studio, R"({"move": )" + std::string(to) + "}");
    const std::vector<Stroke> strokes = studio.preview();
    ASSERT_EQ(strokes.size(), 1u);
    const double width = std::get<BendWidth>(std::get<BendStroke>(strokes[0]).extent).width;
    EXPECT_GT(width, before);
    before = width;
    EXPECT_NE(zone_note(studio).find("The zone is"), std::string::npos);
  }
  run(studio, R"({"key": "Escape"})");
  EXPECT_EQ(zone_note(studio), "");
  studio.document().close();
}

// The finger alone moves, though its zone grows: a limit cylinder keeps its outer border.
TEST_F(StretchTest, AStrongBendOfAFingerStaysSmooth) {
  for (const char* const tool : {"bend", "twist"}) {
    Studio studio(options());
    const Finger& finger = hand_fingers()[2];
    const Vec3d at = finger.base + finger.axis * (0.45 * finger.length);
    run(studio, R"({"size": [800, 600]}
{"new": "hand"}
{"view": {"yaw_deg": 0, "pitch_deg": 0, "target": [0, 0, 0], "height": 2.2}}
{"tool": ")" + std::string(tool) +
                    R"("}
{"click": [)" + std::to_string(at.x) +
                    ", " + std::to_string(at.y) + ", " + std::to_string(at.z) + R"(]}
{"drag": [[40, 40], [300, 300]]})");
    EXPECT_EQ(errors(studio), "");
    ASSERT_EQ(studio.document().shown().history.size(), 1u) << tool;
    EXPECT_LT(stretch_since_start(studio), 5) << tool;
    EXPECT_GT(stretch_since_start(studio), 1.2) << tool;
    EXPECT_TRUE(saved_and_replayed(studio).warnings.empty()) << tool;
    studio.document().close();
  }
}

TEST_F(StretchTest, ColoursFollowTheStrokesAndUndo) {
  Studio studio(options());
  run(studio, ball());
  EXPECT_EQ(stretch_since_start(studio), 1);
  EXPECT_FALSE(stretches_shown(studio.document().shown(), StretchView::last_stroke));
  run(studio, R"({"tool": "ball"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1]]}
{"drag": [[-0.8, 0, 0.6], [-0.9, 0, 0.6]]})");
  const auto start = stretches_shown(studio.document().shown(), StretchView::since_start).value();
  const auto last = stretches_shown(studio.document().shown(), StretchView::last_stroke).value();
  EXPECT_GT(greatest(start), 1.5 * greatest(last));
  EXPECT_GT(greatest(last), 1.05);
  run(studio, R"({"key": "Ctrl+Z"})");
  EXPECT_NEAR(greatest(stretches_shown(studio.document().shown(), StretchView::last_stroke).value()), greatest(start),
              1e-6);
  run(studio, R"({"look_at": 0})");
  EXPECT_EQ(stretch_since_start(studio), 1);
  EXPECT_FALSE(stretches_shown(studio.document().shown(), StretchView::last_stroke));
  studio.document().close();
}

TEST_F(StretchTest, TheOverlayShowsStretchesOnceForEveryChange) {
  Studio studio(options());
  run(studio, ball());
  run(studio, R"({"key": "Shift+G"}
{"tool": "ball"}
{"drag": [[0, 0, 1], [0.3, 0.3, 1]]})");
  EXPECT_EQ(studio.view().settings().stretch, StretchView::since_start);
  Overlay overlay;
  const auto shades = overlay.influence(studio);
  ASSERT_TRUE(shades.has_value());
  EXPECT_TRUE(overlay.knows_stretch());
  EXPECT_TRUE(overlay.scene(studio).show_stretch);
  const double most = stretch_since_start(studio);
  EXPECT_FLOAT_EQ(static_cast<float>(greatest(*shades)), static_cast<float>(std::log(most) / std::log(kGreatestShown)));
  EXPECT_FALSE(overlay.influence(studio));
  run(studio, R"({"show": {"stretch": "off"}})");
  const auto none = overlay.influence(studio);
  ASSERT_TRUE(none.has_value());
  EXPECT_TRUE(none->empty());
  EXPECT_FALSE(overlay.scene(studio).show_stretch);
  studio.document().close();
}

TEST_F(StretchTest, OffersToRemeshWhatTheLastStrokeMadeThin) {
  {
    Studio studio(options());
    run(studio, ball());
    EXPECT_EQ(studio.document().shown().poor_triangles, 0u);
    run(studio, R"({"tool": "ball"}
{"set": {"inner_ratio": 0.7, "drag": "view"}}
{"drag": [[0, 0.9, 0], [0, 2.6, 0]], "steps": 4})");
    EXPECT_GT(studio.document().shown().poor_triangles, 10u);
    const double before = stretch_since_start(studio);
    EXPECT_GT(before, kStrongStretch);
    run(studio, R"({"key": "Shift+R"})");
    EXPECT_EQ(errors(studio), "");
    EXPECT_EQ(studio.document().shown().poor_triangles, 0u);
    ASSERT_EQ(studio.document().shown().history.size(), 1u);
    EXPECT_TRUE(studio.document().shown().history[0]->strokes.back().remesh.has_value());
    EXPECT_GT(positions(studio).size(), 2700u);
    // The surface is as far from where it began as before; finer triangles see more of it.
    EXPECT_GT(stretch_since_start(studio), 0.7 * before);
    EXPECT_EQ(stretches_shown(studio.document().shown(), StretchView::last_stroke).value().size(),
              positions(studio).size());
    const std::vector<Vec3d> after = positions(studio);
    EXPECT_TRUE(saved_and_replayed(studio).shape.positions() == after);
    run(studio, R"({"key": "Ctrl+Z"})");
    EXPECT_EQ(positions(studio).size(), 2562u);
    studio.document().close();
  }
}

// In the middle of faces nothing would be seen, and nothing is made poor.
TEST_F(StretchTest, OffersToRemeshWhereTheTrianglesAreTooLarge) {
  for (const int vertices : {42, 40962}) {
    Studio studio(options());
    run(studio, ball(vertices) + R"({"tool": "move"}
{"set": {"radius": 0.2, "remesh": false}}
{"drag": [[0.3, 0.3, 0.88], [0.3, 0.3, 1.05]], "steps": 4})");
    EXPECT_EQ(errors(studio), "");
    ASSERT_EQ(studio.document().shown().history.size(), 1U);
    EXPECT_EQ(studio.document().shown().is_coarse, vertices == 42);
    run(studio, R"({"key": "Shift+R"})");
    EXPECT_FALSE(studio.document().shown().is_coarse);
    if (vertices == 42) {
      EXPECT_GT(positions(studio).size(), 80U);
    }
    run(studio, R"({"key": "Ctrl+Z"})");
    EXPECT_EQ(studio.document().shown().is_coarse, vertices == 42) << "as it was before";
    run(studio, R"({"key": "Ctrl+Z"})");
    EXPECT_FALSE(studio.document().shown().is_coarse) << "there is no stroke";
    studio.document().close();
  }
}

TEST_F(StretchTest, OffersToRemeshWhatIsFinerThanTheTriangles) {
  const auto painted = [&](int vertices, double depth) {
    Studio studio(options());
    run(studio, ball(vertices) + fmt::format(R"({{"tool": "paint"}}
{{"set": {{"radius": 0.08, "depth": {}}}}}
{{"drag": [[-0.3, 0, 0.95], [0.3, 0, 0.95]], "steps": 20}})",
                                             depth));
    const std::size_t count = studio.document().shown().poor_triangles;
    studio.document().close();
    return count;
  };
  EXPECT_GT(painted(10242, 0.4), 10u);
  EXPECT_EQ(painted(163842, 0.4), 0u) << "the stroke itself is smooth";
  EXPECT_EQ(painted(10242, 0.02), 0u) << "too little to be seen";
}

TEST_F(StretchTest, ThePlacedToolIsEstimatedBeforeItIsUsed) {
  Studio studio(options());
  StretchEstimate estimate;
  run(studio, kCylinder + std::string(R"({"tool": "ball"})"));
  EXPECT_FALSE(estimate.update(studio));
  run(studio, R"({"tool": "bend"}
{"click": [400, 300]})");
  ASSERT_TRUE(estimate.update(studio).has_value());
  EXPECT_FALSE(estimate.update(studio)->is_strong());
  run(studio, R"({"set": {"widens_zone": false, "radius": 0.5}})");
  ASSERT_TRUE(estimate.update(studio).has_value());
  EXPECT_TRUE(estimate.update(studio)->is_strong());
  EXPECT_FALSE(std::isinf(estimate.update(studio)->greatest));
  // Path lines may run to infinity there: it is known without them.
  run(studio, R"({"set": {"radius": 0.15}})");
  EXPECT_TRUE(std::isinf(estimate.update(studio)->greatest));
  EXPECT_TRUE(studio.document().shown().history.empty());
  studio.document().close();
}

}  // namespace
}  // namespace knead::studio::stretch_test
