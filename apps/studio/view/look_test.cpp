// How the shape is drawn, by the events of a person; and tools in perspective.
#include "preferences.h"

#include <gtest/gtest.h>

#include <fstream>

#include "gestures/gesture.h"
#include "knead/error.h"
#include "studio_fixture.h"
#include "view/overlay.h"

namespace knead::studio::look_test {
namespace {

using LookTest = StudioTest;

TEST_F(LookTest, KeysChangeHowTheShapeIsDrawn) {
  Studio studio(options());
  run(studio, ball());
  Overlay overlay;
  const render::LiveScene plain = overlay.scene(studio);
  EXPECT_EQ(plain.relief, render::Relief{.cavity = true});
  EXPECT_EQ(plain.material, render::Material::matcap);
  run(studio, R"({"key": "V"}
{"key": "Shift+V"}
{"key": "Shift+S"}
{"key": "Alt+B"})");
  const render::LiveScene scene = overlay.scene(studio);
  EXPECT_FALSE(scene.relief.cavity);
  EXPECT_TRUE(scene.relief.occlusion);
  EXPECT_EQ(scene.material, render::Material::matcap);
  EXPECT_FALSE(scene.background_bottom == plain.background_bottom);
  EXPECT_NE(scene.matcap, plain.matcap);
  for (std::size_t i = 1; i < render::kMatcapCount; ++i) run(studio, R"({"key": "Shift+S"})");
  EXPECT_EQ(overlay.scene(studio).matcap, plain.matcap);
  run(studio, R"({"key": "V"}
{"key": "Shift+V"}
{"key": "S"}
{"key": "S"}
{"key": "S"}
{"key": "Alt+B"}
{"key": "Alt+B"})");
  const render::LiveScene again = overlay.scene(studio);
  EXPECT_EQ(again.relief, plain.relief);
  EXPECT_EQ(again.material, plain.material);
  EXPECT_EQ(again.background_bottom, plain.background_bottom);
}

TEST_F(LookTest, TheNextStartRemembersIt) {
  const auto look_of = [](const Studio& studio) {
    Look look = studio.view().settings().look;
    look.projection = studio.view().navigation().view.projection;
    look.field_of_view_deg = studio.view().navigation().view.field_of_view_deg;
    return look;
  };
  Look chosen;
  {
    Studio studio(options());
    EXPECT_EQ(look_of(studio), Look{});
    run(studio, R"({"key": "V"}
{"key": "Shift+V"}
{"show": {"matcap": "jade", "background": "#203040"}}
{"view": {"field_of_view_deg": 55}}
{"key": "Numpad 5"})");
    EXPECT_EQ(errors(studio), "");
    studio.view().remember_look();
    chosen = look_of(studio);
  }
  EXPECT_EQ(chosen.matcap, render::Matcap::jade);
  EXPECT_EQ(chosen.projection, render::Projection::orthographic);
  Studio studio(options());
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(look_of(studio), chosen);
}

TEST_F(LookTest, AScriptNamesWhatItCannotShow) {
  Studio studio(options());
  for (const char* line : {R"({"show": {"matcap": "velvet"}})", R"({"show": {"background": "blue"}})",
                           R"({"view": {"field_of_view_deg": 3}})", R"({"view": {"projection": "fisheye"}})"}) {
    EXPECT_THROW(run(studio, line), InvalidInput) << line;
  }
}

// A PNG file of one colour, wider than it is high.
fs::path make_picture(const fs::path& file) {
  render::Image image{8, 4, {}};
  for (int i = 0; i < 8 * 4; ++i) image.pixels.insert(image.pixels.end(), {200, 30, 40, 255});
  std::ofstream(file, std::ios::binary) << render::encode_png(image);
  return file;
}

TEST_F(LookTest, AReferenceStandsBehindTheShapeInItsViewsOnly) {
  Studio studio(options());
  const fs::path file = make_picture(folder_ / "sketch.png");
  run(studio, ball() + R"({"key": "Alt+3"}
{"drop": [")" + file.string() +
                  R"("]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.view().references().size(), 1U);
  EXPECT_EQ(studio.view().references()[0].plane, ReferencePlane::right);
  Overlay overlay;
  const auto images = [&](const char* line) {
    run(studio, line);
    return overlay.scene(studio).images;
  };
  const auto seen = images(R"({"key": "Alt+3"})");
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_NEAR(norm(seen[0].up), 1, 1e-3);     // as high as the ball
  EXPECT_NEAR(norm(seen[0].right), 2, 2e-3);  // by its own shape
  EXPECT_NEAR(seen[0].right.z, -norm(seen[0].right), 1e-9);
  EXPECT_EQ(images(R"({"key": "Ctrl+Alt+3"})").size(), 1U);
  EXPECT_TRUE(images(R"({"key": "Alt+1"})").empty());
  studio.view().references()[0].in_every_view = true;
  EXPECT_EQ(images(R"({"view": {"yaw_deg": 30, "pitch_deg": 20}})").size(), 1U);
  EXPECT_TRUE(images(R"({"key": "Alt+R"})").empty());
  EXPECT_EQ(images(R"({"key": "Alt+R"})").size(), 1U);
  EXPECT_TRUE(images(R"({"reference": null})").empty());
}

TEST_F(LookTest, ReferencesOfAFileAreThereTheNextTime) {
  const fs::path picture = make_picture(folder_ / "sketch.png");
  const fs::path lost = make_picture(folder_ / "lost.png");
  const fs::path shape = folder_ / "shape.ply";
  const std::string opens = R"({"open": ")" + shape.string() + "\"}\n";
  std::vector<Reference> kept;
  {
    Studio studio(options());
    run(studio, ball() + R"({"export": ")" + shape.string() + "\"}\n" + opens);
    run(studio, R"({"reference": ")" + picture.string() +
                    R"(", "plane": "top", "opacity": 0.25, "height": 3, "center": [1, 2, 3], "every_view": true}
{"reference": ")" + lost.string() +
                    "\"}");
    EXPECT_EQ(errors(studio), "");
    studio.view().remember_look();
    kept = studio.view().references();
    ASSERT_EQ(kept.size(), 2U);
    run(studio, R"({"new": "sphere", "vertices": 642})");
    EXPECT_TRUE(studio.view().references().empty());  // they are the other shape's
  }
  fs::remove(lost);
  Studio studio(options());
  run(studio, opens);
  EXPECT_NE(errors(studio).find("lost.png"), std::string::npos);
  ASSERT_EQ(studio.view().references().size(), 1U);
  Reference& reference = studio.view().references()[0];
  EXPECT_EQ(*reference.image, *kept[0].image);
  reference.image = kept[0].image;
  EXPECT_EQ(reference, kept[0]);
}

TEST_F(LookTest, WhatIsNoPictureIsToldAndNothingElse) {
  Studio studio(options());
  std::ofstream(folder_ / "noise.png") << "not a picture";
  run(studio, ball() + R"({"drop": [")" + (folder_ / "noise.png").string() + "\"]}");
  EXPECT_NE(errors(studio).find("noise.png"), std::string::npos);
  EXPECT_TRUE(studio.view().references().empty());
}

class InEveryProjection : public StudioTest, public testing::WithParamInterface<const char*> {};

// Where a place of the scene is clicked, the tool is at that place.
TEST_P(InEveryProjection, ToolsMeetTheSurfaceUnderThePointer) {
  Studio studio(options());
  run(studio, ball(10242) + GetParam() + R"(
{"tool": "ball"}
{"set": {"drag": "view", "start": "surface"}}
{"drag": [[0.3, 0.4, 0.866], [0.35, 0.5, 0.866]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  const auto& stroke = std::get<ImplicitStroke>(studio.document().shown().history[0]->strokes[0].stroke);
  // The ball's triangles lie up to 0.5 h^2 = 0.001 within it; the pointer is exact.
  EXPECT_LT(norm(stroke.path.front() - Vec3d{0.3, 0.4, 0.866}), 0.004);
  // The plane of the drag goes through the start, so that the end is under the pointer, too.
  const auto from = pixel_of(studio.view().screen(), stroke.path.back());
  const auto to = pixel_of(studio.view().screen(), Vec3d{0.35, 0.5, 0.866});
  ASSERT_TRUE(from && to);
  EXPECT_LT(std::hypot(from->x - to->x, from->y - to->y), 2.5);  // pieces shorter than 1% of the radius are left out
}

TEST_P(InEveryProjection, TheGizmoIsMetWhereItIsDrawn) {
  Studio studio(options());
  run(studio, ball() + GetParam() + R"(
{"tool": "rotate"}
{"click": [0.6, 0.3, 0.74]})");
  ASSERT_TRUE(studio.tools().placed().placement);
  const Placement placement = *studio.tools().placed().placement;
  const Screen screen = studio.view().screen();
  const double size = gizmo_size(screen, placement);
  for (const auto& [axis, part] : {std::pair{placement.x, GizmoPart::move_x}, {placement.y, GizmoPart::move_y}}) {
    const auto tip = pixel_of(screen, placement.center + axis * size);
    ASSERT_TRUE(tip);
    EXPECT_EQ(gizmo_part_at(screen, placement, tip->x, tip->y), part);
    // Dragged along itself, the arrow follows the pointer.
    const auto start = pixel_of(screen, placement.center + axis * (0.9 * size));
    const auto end = pixel_of(screen, placement.center + axis * (1.5 * size));
    ASSERT_TRUE(start && end);
    const Placement moved = moved_by(placement, part, dragged_by(screen, placement, part, *start, *end));
    EXPECT_LT(norm(moved.center - placement.center - axis * (0.6 * size)), 1e-6 * size);
  }
}

INSTANTIATE_TEST_SUITE_P(Look, InEveryProjection,
                         testing::Values(R"({"view": {"projection": "orthographic"}})",
                                         R"({"view": {"field_of_view_deg": 5}})",
                                         R"({"view": {"yaw_deg": 15, "pitch_deg": 10, "field_of_view_deg": 30}})",
                                         R"({"view": {"field_of_view_deg": 65, "height": 4}})"));

}  // namespace
}  // namespace knead::studio::look_test
