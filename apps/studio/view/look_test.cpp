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

TEST_F(LookTest, KeptViewsComeBackInTurn) {
  Studio studio(options());
  run(studio, ball());
  const auto yaw = [&] { return studio.view().navigation().view.yaw; };
  run(studio, R"({"key": "Alt+K"})");
  EXPECT_EQ(yaw(), 0) << "none is kept";
  run(studio, R"({"key": "Ctrl+Alt+K"}
{"key": "Alt+3"}
{"key": "Ctrl+Alt+K"})");
  const double right = yaw();
  run(studio, R"({"key": "Alt+7"}
{"key": "Alt+K"})");
  EXPECT_EQ(yaw(), 0);
  EXPECT_EQ(studio.view().navigation().view.pitch, 0);
  run(studio, R"({"key": "Alt+K"})");
  EXPECT_EQ(yaw(), right);
  run(studio, R"({"key": "Alt+K"})");
  EXPECT_EQ(yaw(), 0) << "and again from the first";
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

// What the cursor consists of.
struct Cursor {
  render::Line outer{};
  std::vector<render::Line> dashes{};
  std::vector<render::Line> dots{};
};

Cursor cursor_of(const Studio& studio) {
  std::vector<render::Line> lines;
  add_cursor(studio, {}, lines);
  Cursor cursor;
  for (const render::Line& line : lines) {
    if (line.closed) {
      cursor.outer = line;
    } else if (line.points.size() == 2) {
      cursor.dots.push_back(line);
    } else {
      cursor.dashes.push_back(line);
    }
  }
  return cursor;
}

Vec3d middle_of(const std::vector<Vec3d>& points) {
  Vec3d sum{};
  for (const Vec3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

void expect_round(const render::Line& ring) {
  ASSERT_GT(ring.points.size(), 40U);
  const Vec3d middle = middle_of(ring.points);
  const double radius = norm(ring.points.front() - middle);
  const Vec3d normal = cross(ring.points[0] - middle, ring.points[ring.points.size() / 4] - middle);
  for (const Vec3d& p : ring.points) {
    EXPECT_NEAR(norm(p - middle), radius, 1e-9 * radius);
    EXPECT_NEAR(dot(p - middle, normal), 0, 1e-9);
  }
}

TEST_F(LookTest, TheCursorIsARoundRingOnTheShapeAndBesideIt) {
  Studio studio(options());
  run(studio, ball() + R"({"tool": "paint"}
{"drag": [[-0.5, 0, 0.86], [0.5, 0.1, 0.86]]}
{"tool": "ball"})");
  // On a bump, across its edge, at the edge of the shape, and far beside it.
  for (const auto& [x, y] : {std::pair{400, 300}, {400, 340}, {205, 300}, {60, 60}}) {
    run(studio, R"({"move": [)" + std::to_string(x) + ", " + std::to_string(y) + "]}");
    const Cursor cursor = cursor_of(studio);
    expect_round(cursor.outer);
    EXPECT_EQ(cursor.dashes.size(), 16U);
    const auto seen = pixel_of(studio.view().screen(), middle_of(cursor.outer.points));
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, x, 1e-6);
    EXPECT_NEAR(seen->y, y, 1e-6);
  }
  EXPECT_TRUE(cursor_of(studio).dots.empty());
}

TEST_F(LookTest, TheInnerRingShowsFalloffAndStrength) {
  Studio studio(options());
  run(studio, ball() + R"({"tool": "points"}
{"move": [400, 300]})");
  const auto inner = [&](const char* settings) {
    run(studio, settings);
    const Cursor cursor = cursor_of(studio);
    const render::Line& dash = cursor.dashes.at(0);
    return std::pair{norm(dash.points[0] - middle_of(cursor.outer.points)) /
                         norm(cursor.outer.points[0] - middle_of(cursor.outer.points)),
                     dash.radius / cursor.outer.radius};
  };
  // Where the weight is a half.
  EXPECT_NEAR(inner(R"({"set": {"falloff": 3}})").first, 0.591, 1e-3);
  EXPECT_NEAR(inner(R"({"set": {"falloff": 7}})").first, 0.273, 1e-3);
  const auto [thin_half, thin] = inner(R"({"tool": "paint"}
{"set": {"depth": 0.01}})");
  EXPECT_NEAR(thin_half, 0.54, 1e-3);
  EXPECT_NEAR(thin, 1, 0.03);
  EXPECT_NEAR(inner(R"({"set": {"depth": 1}})").second, 3, 1e-9);
  EXPECT_NEAR(inner(R"({"tool": "crease"}
{"set": {"pinch": 1}})")
                  .second,
              3, 1e-9);
}

TEST_F(LookTest, ADotShowsWhereSymmetryActs) {
  Studio studio(options());
  run(studio, ball() + R"({"set": {"mirror": [true, true, false]}}
{"move": [0.3, 0.4, 0.866]})");
  const Cursor cursor = cursor_of(studio);
  ASSERT_EQ(cursor.dots.size(), 3U);
  for (const render::Line& dot : cursor.dots) {
    const auto seen = pixel_of(studio.view().screen(), dot.points[0]);
    ASSERT_TRUE(seen);
    double nearest = 1e9;
    for (const double x : {-0.3, 0.3}) {
      for (const double y : {-0.4, 0.4}) {
        const auto image = pixel_of(studio.view().screen(), Vec3d{x, y, 0.866});
        if (!(x > 0 && y > 0)) nearest = std::min(nearest, std::hypot(image->x - seen->x, image->y - seen->y));
      }
    }
    EXPECT_LT(nearest, 1);
  }
}

TEST_F(LookTest, PaintThatBeginsBesideTheShapeBeginsWhereItMeetsIt) {
  Studio studio(options());
  run(studio, ball() + R"({"tool": "paint"}
{"drag": [[170, 300], [300, 300]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  const auto& stroke = std::get<PaintStroke>(studio.document().shown().history[0]->strokes[0].stroke);
  ASSERT_FALSE(stroke.samples.empty());
  EXPECT_LT(stroke.samples.front().point.x, -0.9);
  EXPECT_EQ(studio.view().navigation().view.yaw, 0);
  // One that never meets it does nothing.
  run(studio, R"({"drag": [[170, 300], [170, 340]]})");
  EXPECT_EQ(studio.document().shown().history.size(), 1U);
  EXPECT_EQ(errors(studio), "");
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

struct NamedView {
  const char* name;
  const char* script;

  friend std::ostream& operator<<(std::ostream& out, const NamedView& view) { return out << view.name; }
};

class InEveryProjection : public StudioTest, public testing::WithParamInterface<NamedView> {};

// Where a place of the scene is clicked, the tool is at that place.
TEST_P(InEveryProjection, ToolsMeetTheSurfaceUnderThePointer) {
  Studio studio(options());
  run(studio, ball(10242) + GetParam().script + R"(
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
  run(studio, ball() + GetParam().script + R"(
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

INSTANTIATE_TEST_SUITE_P(
    Look, InEveryProjection,
    testing::Values(NamedView{"orthographic", R"({"view": {"projection": "orthographic"}})"},
                    NamedView{"far", R"({"view": {"field_of_view_deg": 5}})"},
                    NamedView{"turned", R"({"view": {"yaw_deg": 15, "pitch_deg": 10, "field_of_view_deg": 30}})"},
                    NamedView{"wide", R"({"view": {"field_of_view_deg": 65, "height": 4}})"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace knead::studio::look_test
