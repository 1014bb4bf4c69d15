// Materials, relief, background and framing of pictures without a window; and the maps that shadows come from.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "knead/editor/render.h"
#include "render/offline/passes.h"
#include "support/pictures.h"

namespace knead::render::look_test {
namespace {

constexpr int kWide = 240;
constexpr int kHigh = 200;

Options options_of_test() {
  Options options;
  options.width = kWide;
  options.height = kHigh;
  options.light_samples = 16;
  options.ground = false;
  return options;
}

Scene scene_of(const Mesh& mesh, Projection projection = Projection::orthographic) {
  Scene scene;
  scene.shapes.emplace_back().mesh = &mesh;
  scene.camera = fit_camera(shapes_box(scene), {0, 0, -1}, {0, 1, 0}, 1.2, {projection, 25, 0.1});
  return scene;
}

// The square from -1 to 1 in x and y with the height z(x).
template <class Height>
Mesh sheet(const Height& height, std::uint32_t cells = 160) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) {
      const double x = 2.0 * i / cells - 1;
      mesh.positions.push_back({x, 2.0 * j / cells - 1, height(x)});
    }
  }
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i;
      mesh.add_face(std::array{a, a + 1, a + cells + 2, a + cells + 1});
    }
  }
  return mesh;
}

class LookTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!no_context().empty()) GTEST_SKIP() << no_context();
  }
};

// Brightness where this x of a sheet is seen.
double brightness_at(const Image& image, const Scene& scene, double x) {
  const int column = static_cast<int>(0.5 * kWide + x * kHigh / scene.camera.height);
  double sum = 0;
  for (int y = kHigh / 2 - 20; y < kHigh / 2 + 20; ++y) sum += at(image, column, y).green;
  return sum / 40;
}

TEST_F(LookTest, CavityDarkensGroovesAndBrightensRidges) {
  const Mesh mesh = sheet([](double x) { return 0.06 * std::cos(4 * 3.14159265358979 * x); });
  const Scene scene = scene_of(mesh);
  Options options = options_of_test();
  const Image plain = render(scene, options);
  options.relief.cavity = true;
  const Image relief = render(scene, options);
  for (const double ridge : {0.0, 0.5}) {
    EXPECT_GT(brightness_at(relief, scene, ridge), 1.02 * brightness_at(plain, scene, ridge)) << ridge;
  }
  for (const double groove : {-0.25, 0.25}) {
    EXPECT_LT(brightness_at(relief, scene, groove), 0.95 * brightness_at(plain, scene, groove)) << groove;
  }
}

TEST_F(LookTest, OcclusionDarkensACornerAndLeavesAPlaneAlone) {
  const Mesh corner = sheet([](double x) { return x < 0.5 ? 0.0 : std::min((x - 0.5) * 8, 0.8); });
  const Scene scene = scene_of(corner);
  Options options = options_of_test();
  options.ambient_occlusion = false;  // the lights' own shadows
  const Image plain = render(scene, options);
  options.relief.occlusion = true;
  const Image relief = render(scene, options);
  EXPECT_LT(brightness_at(relief, scene, 0.48), 0.94 * brightness_at(plain, scene, 0.48));
  EXPECT_NEAR(brightness_at(relief, scene, -0.5), brightness_at(plain, scene, -0.5), 2);
}

TEST_F(LookTest, EveryMatcapLooksDifferentAndHasNoLamps) {
  const Mesh ball = sphere({}, 1);
  Scene scene = scene_of(ball);
  Options options = options_of_test();
  std::vector<Image> pictures{render(scene, options)};
  for (const Matcap matcap : all_matcaps()) {
    options.matcap = matcap;
    pictures.push_back(render(scene, options));
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      double difference = 0;
      for (std::size_t p = 0; p < pictures[i].pixels.size(); ++p) {
        difference += std::abs(pictures[i].pixels[p] - pictures[k].pixels[p]);
      }
      EXPECT_GT(difference / static_cast<double>(kWide * kHigh), 10) << i << ' ' << k;
    }
  }
  options.light_samples = 64;
  EXPECT_EQ(render(scene, options), pictures.back());
}

TEST_F(LookTest, BackgroundsAreAsChosen) {
  const Mesh ball = sphere({}, 1);
  const Scene scene = scene_of(ball);
  Options options = options_of_test();
  options.background = *color_from("#204060");
  const Pixel own = at(render(scene, options), 3, 3);
  EXPECT_NEAR(own.red, 0x20, 1);
  EXPECT_NEAR(own.green, 0x40, 1);
  EXPECT_NEAR(own.blue, 0x60, 1);
  const Background gradient = *background_named("gradient");
  options.background = gradient.top;
  options.background_bottom = gradient.bottom;
  const Image image = render(scene, options);
  EXPECT_NEAR(at(image, 3, 0).green, 255 * gradient.top.green, 2);
  EXPECT_NEAR(at(image, 3, kHigh - 1).green, 255 * gradient.bottom.green, 2);
}

TEST_F(LookTest, TellsHowMuchIsDone) {
  const Mesh ball = sphere({}, 1);
  Options options = options_of_test();
  std::vector<double> parts;
  options.progress = [&](double part) { parts.push_back(part); };
  render(scene_of(ball), options);
  ASSERT_GE(parts.size(), 4U);
  EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end()));
  EXPECT_EQ(parts.back(), 1);
}

// The mean difference of two pictures in steps of 255.
double mean_difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(a.pixels[i] - b.pixels[i]);
  return sum / static_cast<double>(a.pixels.size());
}

// What is saved by default is not seen: a hand under 1024 lights with all samples, and as it is drawn by default.
TEST_F(LookTest, TheDefaultLooksAsWithSixteenTimesTheLights) {
  const Mesh hand = make_shape(ShapeKind::hand, 20'000);
  Scene scene = scene_of(hand);
  scene.camera = fit_camera(shapes_box(scene), {-0.5, -0.4, -0.7}, {0, 1, 0}, 1.2);
  Options options = options_of_test();
  options.ground = true;
  options.light_samples = Options().light_samples;
  const Image image = render(scene, options);
  options.light_samples = 1024;
  options.supersampling = 4;
  EXPECT_LT(mean_difference(image, render(scene, options)), 1.2);
}

TEST_F(LookTest, AFlatThingDarkensTheGroundOnlyBesideIt) {
  Mesh plate;
  for (const double y : {0.0, 0.02}) {
    for (const auto& [x, z] : {std::pair{-1, -1}, {-1, 1}, {1, 1}, {1, -1}}) {
      plate.positions.push_back({static_cast<double>(x), y, static_cast<double>(z)});
    }
  }
  plate.add_face(std::array{3U, 2U, 1U, 0U});
  plate.add_face(std::array{4U, 5U, 6U, 7U});
  for (std::uint32_t i = 0; i < 4; ++i) plate.add_face(std::array{i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4});
  Scene scene = scene_of(plate);
  scene.camera = fit_camera({{-2, 0, -2}, {2, 0.02, 2}}, {-0.5, -0.4, -0.7}, {0, 1, 0}, 1.2);
  Options options = options_of_test();
  options.light_samples = Options().light_samples;
  const Image plain = render(scene, options);
  options.ground = true;
  EXPECT_LT(mean_difference(plain, render(scene, options)), 0.4);
}

TEST_F(LookTest, ABallTurnedInsideOutShowsItsBack) {
  Mesh balls = sphere({-1.2, 0, 0}, 1);
  const Mesh other = sphere({1.2, 0, 0}, 1);
  const auto first = static_cast<std::uint32_t>(balls.vertex_count());
  balls.positions.insert(balls.positions.end(), other.positions.begin(), other.positions.end());
  for (std::size_t f = 0; f < other.face_count(); ++f) {
    std::vector<std::uint32_t> face(other.face(f).rbegin(), other.face(f).rend());
    for (std::uint32_t& v : face) v += first;
    balls.add_face(face);
  }
  const Image image = render(scene_of(balls), options_of_test());
  const Pixel left = at(image, kWide / 4, kHigh / 2);
  const Pixel right = at(image, kWide * 3 / 4, kHigh / 2);
  EXPECT_GT(left.red, left.blue);
  EXPECT_LT(right.red, right.blue);
}

// The tip comes out below, inside out. The volume is positive all the same.
TEST_F(LookTest, APartPushedThroughAShapeShowsItsBack) {
  Mesh ball = sphere({}, 1);
  for (Vec3d& p : ball.positions) {
    if (p.y > 0.3) p = {0.5 * p.x, 0.3 - 2.4 * (p.y - 0.3), 0.5 * p.z};
  }
  Scene scene = scene_of(ball);
  scene.camera = fit_camera({{-1, -1.4, -1}, {1, 1, 1}}, {0, 1, 0.1}, {0, 0, 1}, 1);
  const Pixel middle = at(render(scene, options_of_test()), kWide / 2, kHigh / 2);
  EXPECT_LT(middle.red, middle.blue);
}

TEST_F(LookTest, FromWithinABallItsBackIsSeen) {
  const Mesh ball = sphere({}, 1);
  Scene scene = scene_of(ball, Projection::perspective);
  scene.camera.eye = {0, 0, 0.5};
  scene.camera.target = {};
  Options options = options_of_test();
  options.ambient_occlusion = false;  // no light comes in
  const Pixel middle = at(render(scene, options), kWide / 2, kHigh / 2);
  EXPECT_LT(middle.red, middle.blue);
}

// What casts a shadow stays off the border of a map: places beyond it are looked up there.
TEST(Occluder, HoldsTheBallsOfPoints) {
  DrawSurface cloud;
  cloud.vertices = {{{-1, 0, 0}, {}, {}}, {{1, 0, 0}, {}, {}}};
  const Occluder occluder = make_occluder({cloud}, {0, 1, 0}, 0.1, 100, 0.25);
  EXPECT_GE(occluder.radius, 1.25);
  EXPECT_LT(occluder.radius, 1.3);
}

TEST(ShadowMap, ATriangleCoversTheTexelsWhoseCentresItHolds) {
  Occluder occluder;
  occluder.radius = 1;
  occluder.positions = {{0.1f, 0.1f, 0.5f}, {0.9f, 0.1f, 0.5f}, {0.1f, 0.9f, 0.5f}};
  occluder.indices = {0, 1, 2};
  constexpr int size = 50;
  const LightMatrix identity{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  for (int turn = 0; turn < 2; ++turn) {
    std::vector<std::uint16_t> map(std::size_t{size} * size);
    draw_shadow_maps(occluder, {&identity, 1}, size, 0.01, map);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double u = (x + 0.5) / size;
        const double v = (y + 0.5) / size;
        if (std::min({std::abs(u - 0.1), std::abs(v - 0.1), std::abs(u + v - 1)}) < 1e-3) continue;
        const bool inside = u > 0.1 && v > 0.1 && u + v < 1;
        EXPECT_EQ(map[static_cast<std::size_t>(y * size + x)], inside ? 32767 : 65535) << x << ' ' << y;
      }
    }
    std::swap(occluder.indices[1], occluder.indices[2]);
  }
}

TEST(ShadowMap, TheNearestDepthStaysAndNothingIsDrawnOutside) {
  Occluder occluder;
  occluder.radius = 1;
  occluder.positions = {{-5, -5, 0.75f}, {5, -5, 0.75f}, {0, 9, 0.75f}, {-5, -5, 0.25f}, {5, -5, 0.25f}, {0, 9, 0.25f}};
  occluder.indices = {0, 1, 2, 3, 4, 5};
  occluder.points = {{0.5f, 0.5f, 0.1f}, {3, 3, 0}};
  const LightMatrix identity{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  std::vector<std::uint16_t> map(std::size_t{40} * 40);
  draw_shadow_maps(occluder, {&identity, 1}, 40, 0.05, map);
  const auto at = [&](int x, int y) { return map[static_cast<std::size_t>(y) * 40 + static_cast<std::size_t>(x)]; };
  EXPECT_NEAR(at(3, 3), 0.25 * 65535, 2);
  EXPECT_NEAR(at(20, 20), 0.1 * 65535, 2);
  EXPECT_NEAR(at(20, 24), 0.25 * 65535, 2);
}

TEST(Occluder, IsCutByAPlane) {
  Occluder occluder;
  occluder.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {5, 5, 0}, {6, 5, 0}, {5, 6, 0}};
  occluder.indices = {0, 1, 2, 3, 4, 5};
  occluder.points = {{0, 0, 0}, {4, 0, 0}};
  clip_occluder(occluder, {1, 0, 0, 1});
  EXPECT_EQ(occluder.points.size(), 1U);
  double area = 0;
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    const Vec3d a(occluder.positions[occluder.indices[i]]);
    const Vec3d b(occluder.positions[occluder.indices[i + 1]]);
    const Vec3d c(occluder.positions[occluder.indices[i + 2]]);
    for (const Vec3d& p : {a, b, c}) EXPECT_LE(p.x, 1 + 1e-6);
    area += 0.5 * norm(cross(b - a, c - a));
  }
  EXPECT_NEAR(area, 1.5, 1e-6);  // of 2, half of half of it is beyond
}

TEST(Framing, PointsReachTheMarginsOnBothSides) {
  const Mesh hand = make_shape(ShapeKind::hand, 5'000);
  for (const Projection projection : {Projection::orthographic, Projection::perspective}) {
    for (const double aspect : {0.6, 1.0, 1.8}) {
      for (const double field : {10.0, 25.0, 90.0}) {
        const Camera camera =
            fit_points(hand.positions, {-0.5, -0.4, -0.7}, {0, 1, 0}, aspect, {projection, field, 0.06});
        const CameraFrame frame = camera_frame(camera);
        const double distance = norm(camera.target - camera.eye);
        Box seen;  // in parts of the picture, from -1 to 1
        for (const Vec3d& p : hand.positions) {
          const Vec3d d = p - camera.eye;
          const double scale = projection == Projection::perspective ? distance / dot(d, frame.forward) : 1;
          seen.extend({2 * scale * dot(d, frame.right) / (aspect * camera.height),
                       2 * scale * dot(d, frame.up) / camera.height, 0});
        }
        EXPECT_LT(std::max({-seen.min.x, seen.max.x, -seen.min.y, seen.max.y}), 0.88 + 1e-9);
        const double wide = 0.5 * (seen.max.x - seen.min.x);
        const double high = 0.5 * (seen.max.y - seen.min.y);
        EXPECT_NEAR(std::max(wide, high), 0.88, 1e-6) << aspect << ' ' << field;
        EXPECT_NEAR(seen.min.x + seen.max.x, 0, projection == Projection::orthographic ? 1e-9 : 0.3);
      }
    }
  }
}

TEST(Framing, NoPointsAndOnePointAreSeen) {
  EXPECT_GT(fit_points(std::span<const Vec3d>(), {0, 0, -1}, {0, 1, 0}, 1).height, 0);
  const Vec3d one{3e6, 1, 2};
  const Camera camera = fit_points({&one, 1}, {0, 0, -1}, {0, 1, 0}, 1);
  EXPECT_GT(camera.height, 0);
  EXPECT_NE(camera.eye, camera.target);
}

}  // namespace
}  // namespace knead::render::look_test
