// Splats in the live view: beside the offline renderer, after strokes, and their order.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <numeric>
#include <random>
#include <thread>
#include <vector>

#include "knead/editor/render.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "render/live/live_splats.h"
#include "support/live_view_fixture.h"
#include "support/splat_scenes.h"

namespace knead::render::live_splats_test {
namespace {

constexpr double kAlike = 40;  // dB
constexpr const char* kTurn = R"({"knead": 1}
{"tool": "rotate", "center": [0.8, 0, 0], "axis": [1, 1, 0], "angle_deg": 60, "inner": 0.2, "outer": 1.4}
)";

Mesh capture(std::size_t count = 10'000) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 10'000);
  const std::vector<Triangle> triangles = triangulate(mesh);
  return cover(mesh, triangles, samples_of(mesh, triangles, count));
}

class LiveSplatsTest : public LiveViewTest {
 protected:
  LiveScene scene_from(const Mesh& splats, double azimuth, double elevation, Projection projection) const {
    LiveScene scene = scene_of(splats);
    const ViewDirection from = view_direction(azimuth, elevation, false);
    scene.camera = fit_points(splats.positions, from.direction, from.up, 1.2, {projection, 25, 0.1});
    return scene;
  }

  // The likeness of the live view, as it is, to the offline picture of these splats.
  double likeness(const Mesh& splats, const LiveScene& scene) {
    Options options;
    options.width = kWidth;
    options.height = kHeight;
    options.background = scene.background_top;
    return psnr(error_of(picture(scene), render_splats(splats, scene.camera, options)));
  }
};

TEST_F(LiveSplatsTest, LookAsTheOfflineRendererDrawsThem) {
  const Mesh splats = capture();
  view_->set_shape(splats);
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    for (int view = 0; view < 3; ++view) {
      const LiveScene scene = scene_from(splats, 80 * view, 25 * view - 30, projection);
      EXPECT_GT(likeness(splats, scene), kAlike) << view;
    }
  }
  LiveScene near = scene_from(splats, 20, 10, Projection::perspective);  // most are beside or behind it
  near.camera.eye = near.camera.eye * 0.2 + near.camera.target * 0.8;
  near.camera.shift_x = 0.3;
  EXPECT_GT(likeness(splats, near), kAlike);
}

TEST_F(LiveSplatsTest, ChangeWithADeformationAndBack) {
  Mesh splats = capture();
  const DeformedShape after = replay(borrow(splats), parse_session(kTurn, "s.knead")).shape;
  Mesh deformed = after.to_mesh();
  const LiveScene scene = scene_from(splats, 60, 20, Projection::perspective);
  splats.positions[7].x = deformed.positions[7].x = std::nan("");  // is left out, so that others have other numbers
  const Image before = picture_of(splats, scene);
  const VertexRange all{0, static_cast<std::uint32_t>(splats.vertex_count())};
  view_->move(after.positions(), {&all, 1});
  const double of_centers = likeness(deformed, scene);
  EXPECT_TRUE(view_->set_splats(after.splats()));
  EXPECT_FALSE(view_->set_splats(after.splats()));
  EXPECT_GT(likeness(deformed, scene), kAlike);
  EXPECT_LT(of_centers, 30);
  view_->move(splats.positions, {&all, 1});
  view_->set_splats(nullptr);
  EXPECT_EQ(picture(scene), before);
}

TEST_F(LiveSplatsTest, AreDarkWhereMaskedAndTintedUnderATool) {
  const Mesh splats = capture();
  LiveScene scene = scene_from(splats, 0, 0, Projection::perspective);
  const double bright = mean_brightness(picture_of(splats, scene));
  view_->set_mask(std::vector<float>(splats.vertex_count(), 1.0F));
  EXPECT_LT(mean_brightness(picture(scene)), 0.8 * bright);
  view_->set_mask({});
  EXPECT_EQ(mean_brightness(picture(scene)), bright);
  view_->set_influence(std::vector<float>(splats.vertex_count(), 1.0F));
  const Image plain = picture(scene);
  scene.show_influence = true;
  const Pixel red = at(picture(scene), kWidth / 2, kHeight / 2);
  EXPECT_GT(red.red, red.green + 40);
  EXPECT_EQ(mean_brightness(plain), bright);
}

TEST_F(LiveSplatsTest, HideAToolBehindThemAndNotOneInFront) {
  const Mesh splats = capture();
  LiveScene scene = scene_from(splats, 0, 0, Projection::orthographic);
  const Image plain = picture_of(splats, scene);
  const auto changed = [&](double z) {
    scene.lines = {{{{-0.4, 0, z}, {0.4, 0, z}}, 0.03, false, {1, 0, 1, 1}}};
    const Image image = picture(scene);
    double sum = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) sum += std::abs(image.pixels[i] - plain.pixels[i]);
    return sum;
  };
  EXPECT_LT(changed(-2), 0.6 * changed(2));
}

TEST_F(LiveSplatsTest, AreSortedMeanwhile) {
  const Mesh splats = capture(60'000);
  view_->set_shape(splats);
  LiveScene scene = scene_from(splats, 0, 0, Projection::perspective);
  view_->draw(scene, kWidth, kHeight);
  EXPECT_FALSE(view_->is_sorting());
  const Camera other = scene_from(splats, 170, 40, Projection::perspective).camera;
  scene.camera = other;
  EXPECT_TRUE(view_->draw(scene, kWidth, kHeight));
  EXPECT_TRUE(view_->is_sorting());
  int drawn = 0;
  for (int i = 0; i < 10'000 && view_->is_sorting(); ++i) {
    drawn += view_->draw(scene, kWidth, kHeight) ? 1 : 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(drawn, 1);
  EXPECT_FALSE(view_->is_sorting());
  EXPECT_FALSE(view_->draw(scene, kWidth, kHeight));
  EXPECT_GT(likeness(splats, scene), kAlike);
}

TEST_F(LiveSplatsTest, AreFewerAndLargerInAQuickPicture) {
  const Mesh splats = capture(150'000);
  view_->set_shape(splats);
  LiveScene scene = scene_from(splats, 0, 0, Projection::perspective);
  const gl::Texture color = gl::make_texture(kWidth, kHeight, GL_RGBA8);
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  const auto drawn = [&](int samples) {
    scene.samples = samples;
    view_->draw(scene, kWidth, kHeight);
    Image image{kWidth, kHeight, std::vector<std::uint8_t>(std::size_t{4} * kWidth * kHeight)};
    glReadPixels(0, 0, kWidth, kHeight, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
    return image;
  };
  const Image all = drawn(0);
  const Image some = drawn(1);
  EXPECT_NE(some, all);
  EXPECT_GT(psnr(error_of(some, all)), 20);
  EXPECT_NEAR(covered_pixels(some), covered_pixels(all), 0.05 * covered_pixels(all));
  EXPECT_EQ(drawn(0), all);
}

TEST_F(LiveSplatsTest, NumbersThatAreNoneAreLeftOut) {
  Mesh splats = capture(3000);
  const LiveScene scene = scene_from(splats, 0, 0, Projection::perspective);
  for (Attribute& attribute : splats.attributes) {
    attribute.values[5] = std::nan("");
    attribute.values[6] = -1e300;
  }
  view_->set_shape(splats);
  EXPECT_GT(likeness(splats, scene), kAlike);
  splats.attributes.pop_back();
  splats.attributes.pop_back();  // opacity, and a harmonic
  EXPECT_THROW(view_->set_shape(splats), InvalidInput);
}

TEST(SplatSorter, SortsFromFarToNearAndKeepsTheOrderOfEquals) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> number(-1, 1);
  std::vector<Vec3f> places(150'000);
  for (Vec3f& p : places) p = {number(random), number(random), number(random)};
  for (std::size_t i = 0; i < 1000; ++i) places[140'000 + i] = places[i];
  auto colors = std::make_shared<SplatColors>();
  colors->numbers.resize(3 * places.size(), 0.5F);
  colors->opacities.resize(places.size(), 255);
  const SplatView view{{0.1, 0.2, 0.3}, normalized(Vec3d{1, 2, -3}), true};
  SplatSorter sorter(colors, std::make_shared<SplatTurns>(), places, view);
  int steps = 1;
  while (!sorter.step()) ++steps;
  EXPECT_GT(steps, 5);
  std::vector<std::uint32_t> expected(places.size());
  std::iota(expected.begin(), expected.end(), 0U);
  const auto depth = [&](std::uint32_t i) {
    return static_cast<float>(dot(Vec3d(places[i]) - view.eye, view.forward));
  };
  std::stable_sort(expected.begin(), expected.end(), [&](auto a, auto b) { return depth(a) < depth(b); });
  std::reverse(expected.begin(), expected.end());
  EXPECT_EQ(sorter.order(), expected);
}

}  // namespace
}  // namespace knead::render::live_splats_test
