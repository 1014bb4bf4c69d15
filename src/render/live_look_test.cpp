// Materials and relief of the interactive picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>

#include "knead/error.h"
#include "support/live_view_fixture.h"

namespace knead::render::live_look_test {
namespace {

// The square from -1 to 1 in x and y with the height z(x).
template <class Height>
Mesh sheet(const Height& height, std::uint32_t cells = 200) {
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

class LiveLookTest : public LiveViewTest {
 protected:
  // Brightness in a column of the picture, in which every pixel shows the same x.
  static double column(const Image& image, int x) {
    double sum = 0;
    for (int y = kHeight / 2 - 10; y < kHeight / 2 + 10; ++y) sum += at(image, x, y).green;
    return sum / 20;
  }

  // The column of the picture where x is seen.
  static int column_of(const LiveScene& scene, double x) {
    return static_cast<int>(kWidth / 2 + x * kHeight / scene.camera.height);
  }
};

TEST(Matcaps, HaveNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (const Matcap matcap : all_matcaps()) {
    names.insert(name_of(matcap));
    EXPECT_EQ(matcap_named(name_of(matcap)), matcap);
    EXPECT_FALSE(title_of(matcap).empty());
  }
  EXPECT_EQ(names.size(), kMatcapCount);
  EXPECT_EQ(matcap_named("velvet"), std::nullopt);
}

TEST(Matcaps, ABallIsRoundOnATransparentBackground) {
  for (const Matcap matcap : all_matcaps()) {
    const Image ball = matcap_ball(matcap, 32);
    EXPECT_EQ(at(ball, 0, 0).alpha, 0);
    EXPECT_EQ(at(ball, 16, 16).alpha, 255);
    const auto covered = std::count_if(ball.pixels.begin(), ball.pixels.end(),
                                       [&, i = 0](std::uint8_t value) mutable { return i++ % 4 == 3 && value > 127; });
    // The outline fades within its pixel, so that half of it is inside the circle of radius 15.5.
    EXPECT_NEAR(static_cast<double>(covered), 15.5 * 15.5 * std::numbers::pi, 30);
  }
  EXPECT_THROW(matcap_ball(Matcap::jade, 1), InvalidInput);
}

TEST(Backgrounds, AreNamesOrColours) {
  for (const char* name : {"gradient", "light", "dark"}) EXPECT_TRUE(background_named(name).has_value()) << name;
  const auto own = background_named("#3080fF");
  ASSERT_TRUE(own.has_value());
  EXPECT_EQ(text_of(own->top), "#3080ff");
  EXPECT_EQ(own->top, own->bottom);
  EXPECT_LT(background_named("dark")->top.green, 0.3);
  EXPECT_GT(background_named("light")->top.green, 0.9);
  for (const char* text : {"", "blue", "#12345", "#1234567", "#12345g", "#-12345", "123456"}) {
    EXPECT_FALSE(background_named(text).has_value()) << text;
  }
}

TEST_F(LiveLookTest, EveryMatcapLooksDifferent) {
  const Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball);
  view_->set_shape(ball);
  scene.material = Material::matcap;
  std::vector<Image> pictures;
  for (const Matcap matcap : all_matcaps()) {
    scene.matcap = matcap;
    pictures.push_back(picture(scene));
  }
  const int covered = covered_pixels(pictures.front());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT(different_pixels(pictures[i], pictures[k], 20), covered / 2);
  }
}

TEST_F(LiveLookTest, ASectionIsALineOnTheShapeInEveryMaterial) {
  const Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball);
  scene.camera = fit_camera(bounding_box(ball.positions), {0, 0, -1}, {0, 1, 0}, static_cast<double>(kWidth) / kHeight);
  view_->set_shape(ball);
  const Color red{1, 0, 0, 1};
  for (const Material material : {Material::clay, Material::flat, Material::matcap}) {
    scene.material = material;
    scene.sections.clear();
    const Image plain = picture(scene);
    scene.sections = {{{1, 0, 0}, 0, red}, {{0, 2, 0}, 8, red}};  // through the middle; beyond the shape
    const Image marked = picture(scene);
    const int middle = kWidth / 2;
    int on_line = 0;
    for (int y = kHeight / 4; y < 3 * kHeight / 4; ++y) {
      const auto pixel = at(marked, middle, y);
      if (pixel.red > 180 && pixel.green < 90) ++on_line;
    }
    EXPECT_GT(on_line, 0.9 * kHeight / 2) << static_cast<int>(material);
    int others = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (std::abs(x - middle) > 3 && at(plain, x, y).green != at(marked, x, y).green) ++others;
      }
    }
    EXPECT_EQ(others, 0) << static_cast<int>(material);
  }
  scene.sections.assign(kMaxSections + 1, {{1, 0, 0}, 0, red});
  EXPECT_THROW(picture(scene), InvalidInput);
  scene.sections = {{{0, 0, 0}, 0, red}};
  EXPECT_THROW(picture(scene), InvalidInput);
}

TEST_F(LiveLookTest, FlatAndClayDifferOnTrianglesSmallerThanPixels) {
  const Mesh ball = sphere({}, 1, 160'000);
  LiveScene scene = scene_of(ball);
  const Image clay = picture_of(ball, scene);
  scene.material = Material::flat;
  const Image flat = picture(scene);
  // More than a tenth of full scale in half of what the ball covers.
  EXPECT_GT(different_pixels(flat, clay, 26), covered_pixels(clay) / 2);
}

TEST_F(LiveLookTest, CavityDarkensGroovesAndBrightensRidges) {
  const double waves = 4 * std::numbers::pi;
  const Mesh mesh = sheet([&](double x) { return 0.06 * std::cos(waves * x); });
  LiveScene scene = scene_of(mesh);
  const Image plain = picture_of(mesh, scene);
  scene.relief.cavity = true;
  const Image relief = picture(scene);
  for (const double ridge : {-0.5, 0.0, 0.5}) {
    const int x = column_of(scene, ridge);
    EXPECT_GT(column(relief, x), 1.04 * column(plain, x)) << ridge;
  }
  for (const double groove : {-0.25, 0.25}) {
    const int x = column_of(scene, groove);
    EXPECT_LT(column(relief, x), 0.93 * column(plain, x)) << groove;
    EXPECT_EQ(at(relief, x, kHeight / 2).alpha, 255) << groove << ": nothing shines through";
  }
}

// A ball whose outline stands closely before another ball's surface: neither is a groove or a ridge there.
TEST_F(LiveLookTest, CavityDrawsNoLineWhereOnePartStandsBeforeAnother) {
  Mesh balls = sphere({}, 1, 40'000);
  const Mesh other = sphere({0.1, 0, 0.93}, 0.5, 40'000);
  const auto count = static_cast<std::uint32_t>(balls.vertex_count());
  balls.positions.insert(balls.positions.end(), other.positions.begin(), other.positions.end());
  for (std::size_t f = 0; f < other.face_count(); ++f) {
    const auto face = other.face(f);
    balls.add_face(std::array{face[0] + count, face[1] + count, face[2] + count});
  }
  LiveScene scene = scene_of(balls);
  scene.camera = fit_camera(bounding_box(balls.positions), {0, 0, -1}, {0, 1, 0}, 1.2);
  const Image plain = picture_of(balls, scene);
  scene.relief.cavity = true;
  const Image relief = picture(scene);
  int bright = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) bright += at(relief, x, y).green > 1.25 * at(plain, x, y).green ? 1 : 0;
  }
  EXPECT_LT(bright, 5);
}

TEST_F(LiveLookTest, CavityLeavesAPlaneAloneAndTheBackground) {
  const Mesh plane = sheet([](double) { return 0.0; });
  LiveScene scene = scene_of(plane);
  scene.camera = fit_camera(bounding_box(plane.positions), {0.5, 0.3, -1}, {0, 1, 0}, 1.2);
  const Image plain = picture_of(plane, scene);
  scene.relief = {.cavity = true, .occlusion = true};
  EXPECT_LE(largest_difference(picture(scene), plain), 2);  // a factor of 1 in half precision, blended in eight bits
}

TEST_F(LiveLookTest, OcclusionDarkensACornerAndNothingElse) {
  // A floor that rises to a wall at x = 0.5.
  const Mesh mesh = sheet([](double x) { return x < 0.5 ? 0.0 : std::min((x - 0.5) * 8, 0.8); });
  LiveScene scene = scene_of(mesh);
  const Image plain = picture_of(mesh, scene);
  scene.relief.occlusion = true;
  const Image relief = picture(scene);
  EXPECT_LT(column(relief, column_of(scene, 0.48)), 0.92 * column(plain, column_of(scene, 0.48)));
  EXPECT_NEAR(column(relief, column_of(scene, -0.5)), column(plain, column_of(scene, -0.5)), 2);
  EXPECT_NEAR(column(relief, column_of(scene, 0.9)), column(plain, column_of(scene, 0.9)), 2);
}

TEST_F(LiveLookTest, ReliefWorksWithSamplesWiresCutsAndGlass) {
  const Mesh ball = sphere({}, 1);
  LiveScene scene = scene_of(ball, Projection::perspective);
  scene.wireframe = true;
  scene.clip = Clip{{0, 0, 1}, 0.5, {1, 0, 0, 1}};
  scene.surfaces.push_back({sphere({0, 0, 1}, 0.5), kInnerRed});
  LiveView smooth(4);
  smooth.set_shape(ball);
  const Image plain = smooth.picture(scene, kWidth, kHeight);
  scene.relief = {.cavity = true, .occlusion = true};
  const Image relief = smooth.picture(scene, kWidth, kHeight);
  EXPECT_TRUE(is_background(at(relief, 3, 3)));
  EXPECT_NEAR(mean_brightness(relief), mean_brightness(plain), 8);
  scene.relief = {};
  EXPECT_EQ(smooth.picture(scene, kWidth, kHeight), plain);
}

TEST_F(LiveLookTest, ImagesStandBehindTheShapeAndFollowTheCamera) {
  auto image = std::make_shared<Image>(Image{2, 2, {}});
  for (const auto& [red, green] : {std::pair{255, 0}, {0, 255}, {255, 0}, {0, 255}}) {  // left red, right green
    for (const int value : {red, green, 0, 255}) image->pixels.push_back(static_cast<std::uint8_t>(value));
  }
  const Mesh ball = sphere({}, 0.5);
  LiveScene scene = scene_of(sphere({}, 1), Projection::perspective);
  const Pixel shape = at(picture_of(ball, scene), kWidth / 2, kHeight / 2);
  // Nearer than the ball, and still behind it.
  scene.images.push_back({image, {0, 0, 0.8}, {0.9, 0, 0}, {0, 0.9, 0}, 1});
  const Image both = picture(scene);
  EXPECT_EQ(at(both, kWidth / 2, kHeight / 2).red, shape.red);
  const Pixel left = at(both, kWidth / 2 - 60, kHeight / 2 - 40);
  const Pixel right = at(both, kWidth / 2 + 60, kHeight / 2 - 40);
  EXPECT_GT(left.red, 240);
  EXPECT_LT(left.green, 15);
  EXPECT_GT(right.green, 240);
  EXPECT_TRUE(is_background(at(both, 3, 3)));
  scene.images[0].opacity = 0.5;
  const Pixel half = at(picture(scene), kWidth / 2 - 60, kHeight / 2 - 40);
  EXPECT_NEAR(half.red, 128, 3);
  EXPECT_NEAR(half.blue, 128, 3);                                   // of the background
  scene.camera.eye = scene.camera.target * 2.0 - scene.camera.eye;  // from behind: the other way round
  EXPECT_LT(at(picture(scene), kWidth / 2 - 60, kHeight / 2 - 40).red, 15);
}

TEST_F(LiveLookTest, InPerspectiveNearThingsAreLarger) {
  Mesh two = sphere({-1.5, 0, 1.5}, 1);
  const Mesh far = sphere({1.5, 0, -1.5}, 1);
  const auto first = static_cast<std::uint32_t>(two.vertex_count());
  two.positions.insert(two.positions.end(), far.positions.begin(), far.positions.end());
  for (std::size_t f = 0; f < far.face_count(); ++f) {
    std::vector<std::uint32_t> face(far.face(f).begin(), far.face(f).end());
    for (std::uint32_t& v : face) v += first;
    two.add_face(face);
  }
  const auto halves = [&](Projection projection, double field) {
    LiveScene scene = scene_of(two);
    scene.camera = fit_camera(bounding_box(two.positions), {0, 0, -1}, {0, 1, 0}, 1.2, {projection, field, 0.1});
    const Image image = picture_of(two, scene);
    std::array<double, 2> covered{};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) covered[x < kWidth / 2 ? 0 : 1] += is_background(at(image, x, y)) ? 0 : 1;
    }
    return covered[0] / covered[1];
  };
  EXPECT_NEAR(halves(Projection::orthographic, 30), 1, 0.02);
  EXPECT_GT(halves(Projection::perspective, 30), 1.3);
  EXPECT_GT(halves(Projection::perspective, 80), 2);
}

}  // namespace
}  // namespace knead::render::live_look_test
