// The interactive view: moves, uploads, masks and errors.
#include "knead/editor/render.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "gl/objects.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "render/live/live.h"
#include "support/live_view_fixture.h"

namespace knead::render::live_view_test {
namespace {

TEST_F(LiveViewTest, MovedIsAsIfSetAnew) {
  const Mesh before = sphere({}, 1);
  Mesh after = before;
  const std::vector<VertexRange> ranges = dent(after, 0.8);
  ASSERT_GT(ranges.size(), 1u);
  LiveScene scene = scene_of(before);
  scene.camera.eye = normalized(after.positions.front()) * 5.0;
  const Image start = picture_of(before, scene);
  view_->move(after.positions, ranges);
  const Image moved = picture(scene);
  EXPECT_GT(different_pixels(start, moved), 1000);
  // The box of the dented sphere, and so the renderer's units, are the same to about a thousandth.
  EXPECT_LE(different_pixels(moved, picture_of(after, scene), 3), 30);
}

TEST_F(LiveViewTest, ManySmallMovesAreOneLargeOne) {
  const Mesh before = sphere({}, 1);
  Mesh after = before;
  const std::vector<VertexRange> ranges = dent(after, 0.8);
  const LiveScene scene = scene_of(before);
  view_->set_shape(before);
  for (const VertexRange& range : ranges) view_->move(after.positions, {&range, 1});
  const Image in_steps = picture(scene);
  view_->set_shape(before);
  const VertexRange all = all_of(before);
  view_->move(after.positions, {&all, 1});
  EXPECT_EQ(picture(scene), in_steps);
}

TEST_F(LiveViewTest, MovingThereAndBackChangesNothing) {
  const Mesh before = sphere({}, 1);
  Mesh after = before;
  const std::vector<VertexRange> ranges = dent(after, 0.8);
  LiveScene scene = scene_of(before);
  scene.material = Material::matcap;
  const Image start = picture_of(before, scene);
  view_->move(after.positions, ranges);
  view_->move(before.positions, ranges);
  EXPECT_EQ(picture(scene), start);
}

TEST_F(LiveViewTest, UploadsWhatIsTouchedAndItsRing) {
  const Mesh mesh = sphere({}, 1, 40962);
  view_->set_shape(mesh);
  view_->move(mesh.positions, {});
  EXPECT_EQ(view_->counts().bytes, 0u);
  const VertexRange one{20000, 20001};
  view_->move(mesh.positions, {&one, 1});
  EXPECT_GE(view_->counts().bytes, 7 * sizeof(LiveVertex));  // six vertices round it
  EXPECT_LE(view_->counts().bytes, 600 * sizeof(LiveVertex));
  const VertexRange all = all_of(mesh);
  view_->move(mesh.positions, {&all, 1});
  EXPECT_EQ(view_->counts().bytes, mesh.vertex_count() * sizeof(LiveVertex));
}

TEST_F(LiveViewTest, CoversWhatTheRendererCovers) {
  const Mesh hand = make_shape(ShapeKind::hand, 20000);
  for (const Projection projection : {Projection::orthographic, Projection::perspective}) {
    const LiveScene live = scene_of(hand, projection);
    const Image image = picture_of(hand, live);
    Scene scene;
    scene.shapes.emplace_back().mesh = &hand;
    scene.camera = live.camera;
    Options options;
    options.width = kWidth;
    options.height = kHeight;
    options.supersampling = 1;
    options.light_samples = 16;
    options.ambient_occlusion = false;
    options.background.alpha = 0;
    const Image rendered = Renderer().render(scene, options);
    int covered = 0;
    int different = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool there = rendered.pixels[4 * (static_cast<std::size_t>(y) * kWidth + x) + 3] > 127;
        covered += there ? 1 : 0;
        different += there == is_background(at(image, x, y)) ? 1 : 0;
      }
    }
    EXPECT_GT(covered, 5000);
    EXPECT_LE(different, 25);  // pixels whose middle the outline crosses within rounding
  }
}

TEST_F(LiveViewTest, TheInsideIsSeenThroughHolesAndFromWithin) {
  Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball, Projection::perspective);
  const Pixel outside = at(picture_of(ball, scene), kWidth / 2, kHeight / 2);
  EXPECT_GT(outside.red, outside.blue);  // clay
  // Without the faces in front the far side's back is seen, which is bluish.
  Mesh open;
  open.positions = ball.positions;
  for (std::size_t f = 0; f < ball.face_count(); ++f) {
    if (ball.positions[ball.face(f)[0]].z < 0.3) open.add_face(ball.face(f));
  }
  const Pixel inside = at(picture_of(open, scene), kWidth / 2, kHeight / 2);
  EXPECT_LT(inside.red, inside.blue);
  EXPECT_FALSE(is_background(inside));
  scene.camera.eye = {0, 0, 0.5};
  scene.camera.target = {0, 0, -0.5};
  const Pixel within = at(picture_of(ball, scene), kWidth / 2, kHeight / 2);
  EXPECT_LT(within.red, within.blue);
  EXPECT_FALSE(is_background(within));
}

TEST_F(LiveViewTest, IsUpright) {
  const Mesh ball = sphere({0, 0.5, 0}, 0.2);
  Mesh wide = ball;
  wide.positions.push_back({0, -1, 0});
  wide.positions.push_back({0, 1, 0});
  LiveScene scene = scene_of(wide);
  const Image image = picture_of(ball, scene);
  EXPECT_FALSE(is_background(at(image, kWidth / 2, 60)));
  EXPECT_TRUE(is_background(at(image, kWidth / 2, 140)));
  scene.background_top = {1, 1, 1, 1};
  scene.background_bottom = {0, 0, 0, 1};
  const Image shaded = picture(scene);
  EXPECT_GT(at(shaded, 3, 3).red, 240);
  EXPECT_LT(at(shaded, 3, kHeight - 4).red, 15);
}

TEST_F(LiveViewTest, DrawsIntoTheBoundFramebuffer) {
  const Mesh hand = make_shape(ShapeKind::hand, 5000);
  const LiveScene scene = scene_of(hand);
  const Image image = picture_of(hand, scene);
  const gl::Texture color = gl::make_texture(kWidth, kHeight, GL_RGBA8);
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  view_->draw(scene, kWidth, kHeight);
  GLint bound = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  EXPECT_EQ(static_cast<GLuint>(bound), target.get());
  Image drawn{kWidth, kHeight, std::vector<std::uint8_t>(image.pixels.size())};
  glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, drawn.pixels.data());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; x += 5) {
      ASSERT_EQ(at(drawn, x, kHeight - 1 - y).red, at(image, x, y).red) << x << ' ' << y;
    }
  }
}

TEST_F(LiveViewTest, DrawsIntoAPartOfTheFramebuffer) {
  constexpr int kLeft = 60;
  constexpr int kBottom = 40;
  const Mesh hand = make_shape(ShapeKind::hand, 5000);
  const LiveScene scene = scene_of(hand);
  const Image image = picture_of(hand, scene);
  const gl::Texture color = gl::make_texture(kWidth + kLeft + 10, kHeight + kBottom + 10, GL_RGBA8);
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  glClearColor(1, 0, 1, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  view_->draw(scene, kWidth, kHeight, kLeft, kBottom);
  Image drawn{kWidth, kHeight, std::vector<std::uint8_t>(image.pixels.size())};
  glReadPixels(kLeft, kBottom, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, drawn.pixels.data());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; x += 5) {
      ASSERT_EQ(at(drawn, x, kHeight - 1 - y).red, at(image, x, y).red) << x << ' ' << y;
    }
  }
  std::array<std::uint8_t, 4> beside{};
  glReadPixels(kLeft - 1, kBottom - 1, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, beside.data());
  EXPECT_EQ(beside[0], 255);
  EXPECT_EQ(beside[1], 0) << "what is around the picture stays";
}

// What does not change is not drawn again: whatever changes must be seen. A picture forgets what was drawn.
TEST_F(LiveViewTest, WhatChangesIsDrawnAgain) {
  Mesh hand = make_shape(ShapeKind::hand, 5000);
  view_->set_shape(hand);
  LiveScene scene = scene_of(hand);
  const gl::Texture color = gl::make_texture(kWidth, kHeight, GL_RGBA8);
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  const auto shown = [&] {
    glClearColor(1, 0, 1, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    view_->draw(scene, kWidth, kHeight);
    std::vector<std::uint8_t> pixels(std::size_t{4} * kWidth * kHeight);
    glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
  };
  const VertexRange all{0, static_cast<std::uint32_t>(hand.vertex_count())};
  const std::vector<float> half(hand.vertex_count(), 0.5f);
  const std::vector<std::pair<const char*, std::function<void()>>> changes{
      {"camera", [&] { scene.camera.height *= 1.5; }},
      {"material", [&] { scene.material = Material::matcap; }},
      {"relief", [&] { scene.relief.cavity = true; }},
      {"wires", [&] { scene.wireframe = true; }},
      {"cut",
       [&] {
         scene.clip = Clip{{1, 0, 0}, 0};
       }},
      {"line",
       [&] {
         scene.lines.push_back({{{-1, 0, 0}, {1, 0, 0}}, 0.05});
       }},
      {"arrow",
       [&] {
         scene.arrows.push_back({{0, -1, 0}, {0, 1, 0}, 0.05});
       }},
      {"surface", [&] { scene.surfaces.push_back({sphere({}, 0.5)}); }},
      {"surface moved",
       [&] {
         scene.surfaces[0].mesh.positions[0] = {0, 2, 0};
       }},
      {"background",
       [&] {
         scene.background_top = {0, 1, 0, 1};
       }},
      {"mask", [&] { view_->set_mask(half); }},
      {"values", [&] { view_->set_influence(half); }},
      {"influence", [&] { scene.show_influence = true; }},
      {"move",
       [&] {
         for (Vec3d& p : hand.positions) p.x += 0.1;
         view_->move(hand.positions, {&all, 1});
       }},
      {"shape", [&] { view_->set_shape(sphere({}, 0.7)); }}};
  for (const auto& [name, change] : changes) {
    const auto before = shown();
    change();
    const auto after = shown();
    EXPECT_TRUE(shown() == after) << name;
    view_->picture(scene, 8, 8);
    EXPECT_TRUE(shown() == after) << name;
    const bool is_seen = std::string_view(name) != "values";
    EXPECT_EQ(after != before, is_seen) << name;
  }
}

// While a small part changes, only what is near it on the screen is drawn: no pixel may tell.
TEST_F(LiveViewTest, PartsDrawnAgainAreThoseOfTheWholePicture) {
  for (const auto& [samples, projection, material, cavity] :
       {std::tuple{1, Projection::perspective, Material::matcap, true},
        std::tuple{4, Projection::perspective, Material::matcap, true},
        std::tuple{4, Projection::orthographic, Material::clay, false},
        std::tuple{1, Projection::orthographic, Material::flat, true}}) {
    Mesh ball = sphere({}, 1, 40962);
    LiveView view(samples);
    view.set_shape(ball);
    LiveScene scene = scene_of(ball, projection);
    scene.material = material;
    scene.relief.cavity = cavity;
    scene.lines.push_back({{{-1.5, 1.2, 0}, {1.5, 1.2, 0}}, 0.02});
    const Vec3d first = ball.positions.front();  // the middle of the dent
    scene.surfaces.push_back({sphere(first, 0.1), {0.2f, 0.7f, 0.3f, 0.2f}});
    scene.arrows.push_back({{}, {}, 0.03});
    const gl::Texture color = gl::make_texture(kWidth, kHeight, GL_RGBA8);
    const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
    GLuint query = 0;
    glGenQueries(1, &query);
    const auto shown = [&](GLuint& triangles) {
      glBeginQuery(GL_PRIMITIVES_GENERATED, query);
      view.draw(scene, kWidth, kHeight);
      glEndQuery(GL_PRIMITIVES_GENERATED);
      glGetQueryObjectuiv(query, GL_QUERY_RESULT, &triangles);
      std::vector<std::uint8_t> pixels(std::size_t{4} * kWidth * kHeight);
      glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
      return pixels;
    };
    GLuint triangles = 0;
    shown(triangles);
    int different = 0;
    for (int step = 0; step < 8; ++step) {
      const std::vector<VertexRange> ranges = dent(ball, 0.3);
      view.move(ball.positions, ranges);
      // The tool wanders over the dent, and in the end off the picture.
      const Vec3d way{step == 7 ? 5.0 : 0.05, 0, 0};
      for (Vec3d& p : scene.surfaces[0].mesh.positions) p += way;
      scene.arrows[0] = {first, first * 1.1 + way, 0.03};
      if (step == 3) scene.lines.clear();
      GLuint whole_triangles = 0;
      const auto part = shown(triangles);
      view.picture(scene, 8, 8);
      const auto whole = shown(whole_triangles);
      EXPECT_LE(triangles, step == 3 || step == 7 ? whole_triangles : whole_triangles / 2) << step;
      for (std::size_t i = 0; i < part.size(); ++i) different += part[i] != whole[i] ? 1 : 0;
    }
    EXPECT_EQ(different, 0) << samples << ' ' << static_cast<int>(material);
    glDeleteQueries(1, &query);
  }
}

TEST_F(LiveViewTest, ACoarsePictureIsTheSameEnlarged) {
  const Mesh ball = sphere({}, 1);
  view_->set_shape(ball);
  LiveScene scene = scene_of(ball);
  const gl::Texture color = gl::make_texture(kWidth, kHeight, GL_RGBA8);
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  const auto shown = [&] {
    view_->draw(scene, kWidth, kHeight);
    Image image{kWidth, kHeight, std::vector<std::uint8_t>(std::size_t{4} * kWidth * kHeight)};
    glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
    return image;
  };
  const Image fine = shown();
  scene.coarseness = 2;
  const Image coarse = shown();
  EXPECT_GT(different_pixels(fine, coarse), 100);
  EXPECT_LT(different_pixels(fine, coarse, 20), 1500);  // of 48,000: at the outline
  scene.coarseness = 0;
  EXPECT_THROW(view_->draw(scene, kWidth, kHeight), InvalidInput);
}

TEST_F(LiveViewTest, SamplesSmoothTheOutline) {
  const Mesh ball = sphere({}, 1);
  const LiveScene scene = scene_of(ball);
  const Image hard = picture_of(ball, scene);
  LiveView smooth(4);
  smooth.set_shape(ball);
  const Image soft = smooth.picture(scene, kWidth, kHeight);
  EXPECT_GT(different_pixels(hard, soft, 20), 200);
  EXPECT_LT(different_pixels(hard, soft, 20), 900);  // the outline is about 500 pixels long
  EXPECT_NEAR(mean_brightness(hard), mean_brightness(soft), 1);
  LiveScene hurried = scene;
  hurried.samples = 1;
  EXPECT_EQ(smooth.picture(hurried, kWidth, kHeight), hard);
  EXPECT_EQ(smooth.picture(scene, kWidth, kHeight), soft);
}

TEST_F(LiveViewTest, MaterialsDiffer) {
  const Mesh ball = sphere({}, 1, 642);
  LiveScene scene = scene_of(ball);
  const Image clay = picture_of(ball, scene);
  scene.material = Material::matcap;
  EXPECT_GT(different_pixels(picture(scene), clay), 1000);
  scene.material = Material::flat;
  EXPECT_GT(different_pixels(picture(scene), clay), 1000);
}

TEST_F(LiveViewTest, FlatFacesHaveOneColorEach) {
  const Mesh box = cube();
  LiveScene scene = scene_of(box);
  scene.material = Material::flat;
  scene.camera.projection = Projection::orthographic;
  const Image image = picture_of(box, scene);
  constexpr int x = kWidth / 2;
  constexpr int y = kHeight / 2;
  const Pixel middle = at(image, x, y);
  EXPECT_NEAR(middle.red, at(image, x - 40, y - 30).red, 1);
  scene.material = Material::clay;  // even, too, because it stops at creases
  const Image clay = picture(scene);
  EXPECT_NEAR(at(clay, x, y).red, at(clay, x - 40, y - 30).red, 8);
}

TEST_F(LiveViewTest, MatcapTurnsWithTheCamera) {
  const Mesh ball = sphere({}, 1, 10242);
  LiveScene scene = scene_of(ball);
  scene.material = Material::matcap;
  const Image front = picture_of(ball, scene);
  scene.camera =
      fit_camera(bounding_box(ball.positions), {1, 0, 0}, {0, 1, 0}, 1.2, {Projection::orthographic, 25, 0.1});
  EXPECT_LE(different_pixels(front, picture(scene), 4), 60);  // samples on the outline
}

TEST_F(LiveViewTest, WireframeDarkensTheEdgesOfPolygonsOnly) {
  const Mesh box = cube();
  LiveScene scene = scene_of(box);
  const Image bare = picture_of(box, scene);
  scene.wireframe = true;
  const Image wired = picture(scene);
  EXPECT_LT(mean_brightness(wired), mean_brightness(bare));
  const int across = different_pixels(wired, bare);
  EXPECT_GT(across, 400);
  EXPECT_LT(across, 1300);  // four edges of 160 pixels; the diagonals would be another 226
  EXPECT_EQ(at(wired, kWidth / 2, kHeight / 2).red, at(bare, kWidth / 2, kHeight / 2).red);
}

TEST_F(LiveViewTest, WiresFollowTheMovingShape) {
  const Mesh before = sphere({}, 1, 642);
  Mesh after = before;
  for (Vec3d& p : after.positions) p = p * 0.5;
  LiveScene scene = scene_of(before);
  scene.wireframe = true;
  view_->set_shape(before);
  const VertexRange all = all_of(before);
  view_->move(after.positions, {&all, 1});
  const Image image = picture(scene);
  EXPECT_TRUE(is_background(at(image, kWidth / 2, 30)));
  EXPECT_TRUE(is_background(at(image, kWidth / 2 + 60, kHeight / 2)));
}

TEST_F(LiveViewTest, MeshColorsAreShown) {
  Mesh ball = sphere({}, 1);
  Attribute color{"color", Domain::vertex, NumberType::uint8, 3, {}};
  for (std::size_t v = 0; v < ball.vertex_count(); ++v) color.values.insert(color.values.end(), {0, 0, 255});
  ball.attributes.push_back(color);
  LiveScene scene = scene_of(ball);
  for (const Material material : {Material::clay, Material::matcap, Material::flat}) {
    scene.material = material;
    const Pixel blue = at(picture_of(ball, scene), kWidth / 2, kHeight / 2);
    EXPECT_GT(blue.blue, blue.red + 50);
  }
}

TEST_F(LiveViewTest, NothingIsClippedWhenTheShapeGrows) {
  const Mesh ball = sphere({}, 1);
  Mesh large = ball;
  for (Vec3d& p : large.positions) p = p * 8.0;
  LiveScene scene = scene_of(large, Projection::perspective);
  const Image expected = picture_of(large, scene);
  view_->set_shape(ball);
  const VertexRange all = all_of(ball);
  view_->move(large.positions, {&all, 1});
  EXPECT_LE(different_pixels(picture(scene), expected, 3), 20);
  EXPECT_NEAR(view_->box().max.x, bounding_box(large.positions).max.x, 1e-5);
}

TEST_F(LiveViewTest, SizeAndDistanceFromTheOriginDoNotMatter) {
  const Image expected = picture_of(sphere({}, 1), scene_of(sphere({}, 1)));
  for (const auto& [center, radius] : {std::pair{Vec3d{1e-3, 2e-3, 5e-3}, 1e-9}, {Vec3d{3e6, -2e6, 1e6}, 1.0}}) {
    const Mesh ball = sphere(center, radius);
    EXPECT_LE(different_pixels(picture_of(ball, scene_of(ball)), expected, 3), 60);
  }
}

TEST_F(LiveViewTest, PolygonsOfManyCornersAndPointClouds) {
  Mesh disc;
  std::vector<std::uint32_t> face;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const double angle = 2 * std::numbers::pi * i / 60;
    disc.positions.push_back({std::cos(angle), std::sin(angle), 0});
    face.push_back(i);
  }
  disc.add_face(face);
  LiveScene scene = scene_of(disc);
  scene.wireframe = true;
  EXPECT_FALSE(is_background(at(picture_of(disc, scene), kWidth / 2, kHeight / 2)));
  Mesh cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, std::nan(""), 0}, {1, 1, 0}};
  scene = scene_of(disc);
  scene.camera = fit_camera({{0, 0, 0}, {1, 1, 0}}, {0, 0, -1}, {0, 1, 0}, 1.2, {Projection::orthographic, 25, 0.1});
  const int four = covered_pixels(picture_of(cloud, scene));
  EXPECT_GT(four, 50);
  EXPECT_LT(four, 1000);
  cloud.positions[0] = {0.5, 0.5, 0};
  const VertexRange first{0, 1};
  view_->move(cloud.positions, {&first, 1});
  EXPECT_EQ(view_->counts().bytes, sizeof(LiveVertex));
  EXPECT_FALSE(is_background(at(picture(scene), kWidth / 2, kHeight / 2)));
}

TEST_F(LiveViewTest, NothingToDrawIsFine) {
  LiveScene scene = scene_of(sphere({}, 1));
  scene.wireframe = true;
  scene.clip = Clip{};
  scene.surfaces.emplace_back();
  EXPECT_TRUE(is_background(at(picture(scene), 50, 50)));
  EXPECT_TRUE(view_->box().empty());
  view_->set_shape({});
  view_->move({}, {});
  EXPECT_TRUE(is_background(at(picture(scene), 50, 50)));
  view_->draw(scene, 0, 10);
  const double nan = std::nan("");
  Mesh flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {nan, 0, 0}, {0, 1, 0}};
  for (const auto& face : {std::array{0u, 1u, 2u}, {0u, 0u, 0u}, {0u, 1u, 3u}}) flat.add_face(face);
  flat.add_face(std::array{0u, 1u});
  EXPECT_TRUE(is_background(at(picture_of(flat, scene), kWidth / 2, kHeight / 2)));
}

TEST_F(LiveViewTest, RefusesWhatDoesNotFit) {
  const Mesh ball = sphere({}, 1, 642);
  view_->set_shape(ball);
  const VertexRange beyond{600, 643};
  EXPECT_THROW(view_->move(ball.positions, {&beyond, 1}), InvalidInput);
  EXPECT_THROW(view_->move(std::span(ball.positions).first(600), {}), InvalidInput);
  LiveScene scene = scene_of(ball);
  EXPECT_THROW(view_->picture(scene, 1 << 20, 10), InvalidInput);
  EXPECT_THROW(view_->picture(scene, 0, 10), InvalidInput);
  scene.camera.eye = scene.camera.target;
  EXPECT_THROW(picture(scene), InvalidInput);
}

}  // namespace
}  // namespace knead::render::live_view_test
