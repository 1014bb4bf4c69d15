// Pictures of the offline renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/error.h"
#include "support/pictures.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#ifndef __clang_analyzer__  // it follows stb's own code and finds leaks there
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#endif
#define STBI_NO_STDIO
#include <stb_image.h>
#pragma GCC diagnostic pop

namespace knead::render::render_test {
namespace {

// A ball of quads, with triangles at its poles.
Mesh make_ball(const Vec3d& center, double radius) {
  constexpr std::uint32_t around = 192;
  constexpr std::uint32_t down = 96;
  Mesh mesh;
  for (std::uint32_t j = 0; j <= down; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const double polar = std::numbers::pi * j / down;
      const double angle = 2 * std::numbers::pi * i / around;
      const Vec3d out{std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar)};
      mesh.positions.push_back(center + out * radius);
    }
  }
  for (std::uint32_t j = 0; j < down; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * around + i;
      const std::uint32_t b = j * around + (i + 1) % around;
      mesh.add_face(std::array{a, a + around, b + around, b});
    }
  }
  return mesh;
}

// The number of pixels covered, from the alpha of a picture without background and ground.
double coverage(const Image& image) {
  double sum = 0;
  for (std::size_t i = 3; i < image.pixels.size(); i += 4) sum += image.pixels[i] / 255.0;
  return sum;
}

Options small_options() {
  Options options;
  options.width = 240;
  options.height = 200;
  options.light_samples = 16;
  return options;
}

Options cutout_options() {
  Options options = small_options();
  options.background.alpha = 0;
  options.ground = false;
  return options;
}

class RenderTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!no_context().empty()) GTEST_SKIP() << no_context();
  }

  static Scene scene_of(const Mesh& mesh, Projection projection = Projection::orthographic) {
    Scene scene;
    scene.shapes.emplace_back().mesh = &mesh;
    scene.camera = fit_camera(shapes_box(scene), {0, 0, -1}, {0, 1, 0}, 1.2, {projection, 25, 0.1});
    return scene;
  }
};

TEST_F(RenderTest, OrthographicBallCoversItsDisc) {
  const Mesh ball = make_ball({}, 1);
  const Scene scene = scene_of(ball);
  const Options options = cutout_options();
  const double pixels_per_unit = options.height / scene.camera.height;
  const double disc = std::numbers::pi * pixels_per_unit * pixels_per_unit;
  // The polygon of 192 sides misses 0.02%; 3 x 3 samples per pixel leave well below 0.3% on a circle of 500 pixels.
  EXPECT_NEAR(coverage(render(scene, options)) / disc, 1, 0.004);
}

TEST_F(RenderTest, PerspectiveBallCoversItsCone) {
  const Mesh ball = make_ball({}, 1);
  const Scene scene = scene_of(ball, Projection::perspective);
  const Options options = cutout_options();
  const double distance = norm(scene.camera.eye);
  const double at_target = distance / std::sqrt(distance * distance - 1);  // where the cone round the ball is cut
  const double radius = at_target * options.height / scene.camera.height;
  EXPECT_NEAR(coverage(render(scene, options)) / (std::numbers::pi * radius * radius), 1, 0.004);
}

TEST_F(RenderTest, AShiftOfTheLensMovesThePicture) {
  const Mesh ball = make_ball({0.2, -0.1, 0.3}, 0.5);
  for (const Projection projection : {Projection::orthographic, Projection::perspective}) {
    Scene scene = scene_of(ball, projection);
    scene.camera.height *= 2;
    const Options options = cutout_options();
    const Image plain = render(scene, options);
    scene.camera.shift_x = 2 * 40.0 / options.width;  // 40 pixels to the right, 20 up
    scene.camera.shift_y = 2 * 20.0 / options.height;
    const Image shifted = render(scene, options);
    int seen = 0;
    int greatest = 0;
    for (int y = 20; y < options.height; ++y) {
      for (int x = 0; x + 40 < options.width; ++x) {
        const auto alpha = [&](const Image& image, int i, int j) {
          return static_cast<int>(image.pixels[4 * (static_cast<std::size_t>(j) * image.width + i) + 3]);
        };
        greatest = std::max(greatest, std::abs(alpha(plain, x, y) - alpha(shifted, x + 40, y - 20)));
        seen += alpha(plain, x, y) == 255 ? 1 : 0;
      }
    }
    EXPECT_GT(seen, 1000);
    EXPECT_LE(greatest, 29) << "one of 9 samples on the rim, by rounding";
  }
}

TEST_F(RenderTest, SizeAndDistanceFromTheOriginDoNotMatter) {
  const Mesh ball = make_ball({}, 1);
  const Mesh tiny = make_ball({1e-3, 2e-3, 5e-3}, 1e-9);
  const Mesh far = make_ball({3e6, -2e6, 1e6}, 1);
  const Options options = cutout_options();
  const double covered = coverage(render(scene_of(ball), options));
  EXPECT_NEAR(coverage(render(scene_of(tiny), options)), covered, 0.001 * covered);
  EXPECT_NEAR(coverage(render(scene_of(far), options)), covered, 0.001 * covered);
}

TEST_F(RenderTest, BackgroundIsExact) {
  const Mesh ball = make_ball({}, 1);
  Options options = small_options();
  options.ground = false;
  const Pixel white = at(render(scene_of(ball), options), 2, 2);
  EXPECT_EQ(white.red + white.green + white.blue + white.alpha, 4 * 255);
  options.background.alpha = 0;
  EXPECT_EQ(at(render(scene_of(ball), options), 2, 2).alpha, 0);
}

TEST_F(RenderTest, GroundCatchesShadowsWhereItIsSeenFromAbove) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  Options options = cutout_options();
  for (const double down : {-1.0, 1.0}) {
    scene.camera = fit_camera(shapes_box(scene), {0, down, -1}, {0, 1, 0}, 1.2, {Projection::perspective, 25, 0.25});
    options.ground = false;
    const double without = coverage(render(scene, options));
    options.ground = true;
    const double shadow = coverage(render(scene, options)) / without - 1;
    EXPECT_GT(shadow, down < 0 ? 0.05 : -1e-9);
    EXPECT_LT(shadow, down < 0 ? 1.0 : 1e-9);
  }
}

TEST_F(RenderTest, ShellsTintWhatLiesBehindThem) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  Options options = small_options();
  options.ground = false;
  const Pixel bare = at(render(scene, options), 120, 100);
  scene.surfaces.push_back({make_ball({0, 0, 1}, 0.5), kInnerRed});
  const Pixel red = at(render(scene, options), 120, 100);
  EXPECT_LT(red.green, bare.green - 20);
  EXPECT_GT(red.red - red.green, bare.red - bare.green + 20);
  scene.surfaces[0].color = kOuterGreen;
  const Pixel green = at(render(scene, options), 120, 100);
  EXPECT_GT(green.green - green.red, bare.green - bare.red + 10);
  // A shell within the shape is hidden by it.
  scene.surfaces[0].mesh = make_ball({}, 0.5);
  EXPECT_EQ(at(render(scene, options), 120, 100).red, bare.red);
}

TEST_F(RenderTest, ShellsDoNotDependOnTheirOrder) {
  const Mesh ball = make_ball({}, 0.4);
  Scene scene = scene_of(ball);
  scene.surfaces = {{make_ball({0.2, 0, 0}, 0.3), kInnerRed}, {make_ball({-0.1, 0, 0.1}, 0.5), kOuterGreen}};
  const Image image = render(scene, small_options());
  std::swap(scene.surfaces[0], scene.surfaces[1]);
  EXPECT_EQ(render(scene, small_options()), image);
}

TEST_F(RenderTest, RodsShineThroughAndCoverInFront) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  const Pixel bare = at(render(scene, small_options()), 120, 100);
  scene.arrows.push_back({{-0.5, 0, 0}, {0.5, 0, 0}, 0.06, {0, 0, 1, 1}});
  const Pixel hidden = at(render(scene, small_options()), 120, 100);
  EXPECT_LT(hidden.red, bare.red - 10);
  scene.arrows.clear();
  scene.lines.push_back({{{-0.5, 0, 1.2}, {0.5, 0, 1.2}}, 0.06, false, {0, 0, 1, 1}});
  const Pixel shown = at(render(scene, small_options()), 120, 100);
  EXPECT_LT(shown.red, hidden.red);
  EXPECT_GT(shown.blue, 150);
  scene.lines[0].points = {{-0.5, 0, 1}, {0.5, 0, 1}};  // its far half lies in the ball
  const Pixel half = at(render(scene, small_options()), 120, 100);
  EXPECT_NEAR(half.red, shown.red, 10);
}

TEST_F(RenderTest, SmoothShadingStopsAtCreases) {
  const Mesh mesh = cube();
  Scene scene = scene_of(mesh);
  scene.camera = fit_camera(shapes_box(scene), {-1, -1, -1}, {0, 1, 0}, 1.2);
  Options options = small_options();
  options.ambient_occlusion = false;
  const Image creased = render(scene, options);
  options.crease_angle_deg = 120;
  EXPECT_NE(render(scene, options), creased);
  options.shading = Shading::flat;
  EXPECT_EQ(render(scene, options), creased);
}

TEST_F(RenderTest, WireframeFollowsPolygonsNotTriangles) {
  const Mesh mesh = cube();
  Scene scene = scene_of(mesh);
  Options options = small_options();
  const Pixel bare = at(render(scene, options), 120, 100);
  options.wireframe = true;
  EXPECT_EQ(at(render(scene, options), 120, 100).red, bare.red);
}

TEST_F(RenderTest, WiresDoNotHideASurfaceOfTinyTriangles) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  Options options = small_options();
  const Image bare = render(scene, options);
  options.wireframe = true;
  const Image wired = render(scene, options);
  EXPECT_NE(wired, bare);
  for (const int x : {100, 110, 120, 130}) EXPECT_GT(at(wired, x, 100).red, 0.75 * at(bare, x, 100).red);
}

TEST_F(RenderTest, MeshColorsAreShownWhenAsked) {
  Mesh ball = make_ball({}, 1);
  Attribute color{"color", Domain::vertex, NumberType::uint8, 3, {}};
  for (std::size_t v = 0; v < ball.vertex_count(); ++v) color.values.insert(color.values.end(), {0, 0, 255});
  ball.attributes.push_back(color);
  Scene scene = scene_of(ball);
  EXPECT_GT(at(render(scene, small_options()), 120, 100).red, 100);
  scene.shapes[0].use_mesh_colors = true;
  const Pixel blue = at(render(scene, small_options()), 120, 100);
  EXPECT_GT(blue.blue, blue.red + 50);
}

TEST_F(RenderTest, CutIsFlatAndInItsColor) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  scene.clip = Clip{{0, 0, 2}, 0, {1, 0, 0, 1}};  // the half before z = 0
  Options options = small_options();
  options.ambient_occlusion = false;
  const Image image = render(scene, options);
  const Pixel middle = at(image, 120, 100);
  const Pixel left = at(image, 80, 100);
  EXPECT_GT(middle.red, middle.green + 80);
  EXPECT_NEAR(middle.red, left.red, 2);
  scene.clip->normal = {0, 0, -1};  // the half behind: the cut is out of sight
  EXPECT_LT(at(render(scene, options), 120, 100).red, at(render(scene, options), 120, 100).green + 80);
}

TEST_F(RenderTest, CutBesideTheShapeChangesNothing) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball, Projection::perspective);
  const Image whole = render(scene, small_options());
  for (const Clip& clip : {Clip{{0, 0, 1}, 1.5, {}}, Clip{{0, 0, 1}, 100, {}}, Clip{{0, 0, -1}, 1.5, {}}}) {
    scene.clip = clip;
    EXPECT_EQ(render(scene, small_options()), whole);
  }
}

TEST_F(RenderTest, CutsLeaveToolsWhole) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  scene.surfaces.push_back({make_ball({0, 0, 1}, 0.5), {0, 1, 0, 0.5f}});
  scene.lines.push_back({.points = {{-0.8, 0, 1.6}, {0.8, 0, 1.6}}, .radius = 0.05, .color = {0, 0, 1, 1}});
  Options options = small_options();
  options.ambient_occlusion = false;
  scene.clip = Clip{{0, 0, 1}, 0, {1, 0, 0, 1}};
  const Image image = render(scene, options);
  const Pixel rod = at(image, 120, 100);
  EXPECT_GT(rod.blue, rod.red + 80);
  const Pixel glass = at(image, 120, 90);  // the cut, seen through two layers of green
  EXPECT_GT(glass.green, glass.blue + 50);
  EXPECT_GT(glass.green, glass.red);
}

TEST_F(RenderTest, PointCloudsAreDiscs) {
  Mesh points;
  points.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  Scene scene = scene_of(points);
  Options options = cutout_options();
  options.point_radius = 0.1;
  const double radius = options.point_radius * options.height / scene.camera.height;
  EXPECT_NEAR(coverage(render(scene, options)) / (4 * std::numbers::pi * radius * radius), 1, 0.05);
}

TEST_F(RenderTest, DegenerateMeshesDrawNothingAndDoNotFail) {
  const double nan = std::nan("");
  Mesh flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {nan, 0, 0}, {0, 1, 0}};
  for (const auto& face : {std::array{0u, 1u, 2u}, {0u, 0u, 0u}, {0u, 1u, 3u}}) flat.add_face(face);
  flat.add_face(std::array{0u, 1u});
  Mesh point;
  point.positions = {{5, 5, 5}};
  const Mesh empty;
  Scene scene = scene_of(flat);
  EXPECT_EQ(coverage(render(scene, cutout_options())), 0);
  EXPECT_EQ(coverage(render(scene_of(empty), cutout_options())), 0);
  EXPECT_GT(coverage(render(scene_of(point), cutout_options())), 0);
  scene.shapes[0].mesh = nullptr;
  EXPECT_EQ(coverage(render(scene, cutout_options())), 0);
}

TEST_F(RenderTest, FinerThanTheShadowMapsIsStillRight) {
  // 8 balls of 18,432 quads are above the number of triangles from which shadows are cast by a coarser copy.
  Mesh balls = make_ball({}, 1);
  Scene scene = scene_of(balls);
  const Pixel alone = at(render(scene, small_options()), 120, 100);
  for (int i = 0; i < 7; ++i) scene.shapes.emplace_back().mesh = &balls;
  const Pixel many = at(render(scene, small_options()), 120, 100);
  EXPECT_NEAR(many.red, alone.red, 3);
}

TEST_F(RenderTest, SameBitsTwice) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  scene.surfaces.push_back({make_ball({0, 0, 1}, 0.5), kInnerRed});
  const Image image = render(scene, small_options());
  EXPECT_EQ(render(scene, small_options()), image);
  const gl::OffscreenContext context;
  Renderer renderer;
  EXPECT_EQ(renderer.render(scene, small_options()), image);
  EXPECT_EQ(renderer.render(scene, small_options()), image);
}

// A large picture is drawn in bands, so that one does not wait long for it to stop.
TEST_F(RenderTest, ALargePictureThatIsWatchedHasTheSameBitsAndStopsSoon) {
  const Mesh ball = make_ball({0, 0, 0}, 1);
  Scene scene;
  scene.shapes.emplace_back().mesh = &ball;
  scene.camera = fit_points(ball.positions, {0.3, -0.4, -1}, {0, 1, 0}, 1);
  Options options;
  options.width = options.height = 640;
  options.light_samples = 16;
  const Image alone = render(scene, options);
  std::vector<double> parts;
  options.progress = [&](double part) { parts.push_back(part); };
  EXPECT_TRUE(render(scene, options) == alone);
  EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end()));
  EXPECT_EQ(parts.back(), 1);
  EXPECT_GT(parts.size(), 9U);
  const std::size_t at = parts.size() / 2;
  std::size_t reports = 0;
  options.progress = [&](double /*part*/) {
    if (++reports == at) throw Cancelled();
  };
  EXPECT_THROW(render(scene, options), Cancelled);
  EXPECT_EQ(reports, at);
  options.progress = {};
  EXPECT_TRUE(render(scene, options) == alone) << "the next picture is right";
}

// The ground of a large picture has larger texels.
TEST_F(RenderTest, TheGroundOfALargePictureIsDarkInTheSamePlaces) {
  const Mesh ball = make_ball({0, 0, 0}, 1);
  Scene scene;
  scene.shapes.emplace_back().mesh = &ball;
  Options options = small_options();
  options.width = 601;
  options.height = 900;
  scene.camera = fit_points(ball.positions, {0.3, -0.6, -1}, {0, 1, 0}, 601.0 / 900);
  const Image small = render(scene, options);
  options.width *= 2;
  options.height *= 2;
  const Image large = render(scene, options);
  double difference = 0;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) difference += std::abs(at(small, x, y).red - at(large, 2 * x, 2 * y).red);
  }
  EXPECT_LT(difference / (small.width * small.height), 0.7);
  EXPECT_LT(at(small, 450, 800).red, 250) << "there is a shadow";
}

TEST_F(RenderTest, RefusesWhatMeansNothing) {
  const Mesh ball = make_ball({}, 1);
  Scene scene = scene_of(ball);
  Options options = small_options();
  options.width = 0;
  EXPECT_THROW(render(scene, options), InvalidInput);
  options.width = 1 << 20;
  EXPECT_THROW(render(scene, options), InvalidInput);
  options = small_options();
  options.supersampling = 5;
  EXPECT_THROW(render(scene, options), InvalidInput);
  options = small_options();
  scene.clip = Clip{{0, 0, 0}, 0, {}};
  EXPECT_THROW(render(scene, options), InvalidInput);
  scene.clip.reset();
  scene.camera.eye = scene.camera.target;
  EXPECT_THROW(render(scene, options), InvalidInput);
}

Image gradient(int width, int height) {
  Image image{width, height, {}};
  for (int i = 0; i < 4 * width * height; ++i) image.pixels.push_back(static_cast<std::uint8_t>(i * 7 % 256));
  return image;
}

struct Decoded {
  int width = 0;
  int height = 0;
  int channels = 0;                                                                        // of the file
  std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels{nullptr, &stbi_image_free};  // always of four
};

Decoded decoded(const std::string& file) {
  Decoded image;
  image.pixels.reset(stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(file.data()), static_cast<int>(file.size()),
                                           &image.width, &image.height, &image.channels, 4));
  return image;
}

TEST(Image, PngKeepsEveryByte) {
  const Image image = gradient(37, 23);
  const Decoded png = decoded(encode_png(image));
  ASSERT_NE(png.pixels, nullptr);
  EXPECT_EQ(png.width, 37);
  EXPECT_EQ(png.height, 23);
  EXPECT_EQ(png.channels, 4);
  EXPECT_TRUE(std::equal(image.pixels.begin(), image.pixels.end(), png.pixels.get()));
  EXPECT_THROW(encode_png({}), InvalidInput);
}

TEST(Image, OpaquePngHasNoAlpha) {
  Image image = gradient(37, 23);
  for (std::size_t i = 3; i < image.pixels.size(); i += 4) image.pixels[i] = 255;
  const std::string file = encode_png(image);
  EXPECT_EQ(decoded(file).channels, 3);
  EXPECT_EQ(decode_image(file), image);
}

TEST(Image, JpegKeepsWhatOneSees) {
  Image image{64, 48, {}};
  for (int i = 0; i < 64 * 48; ++i) {
    for (const int value : {4 * (i % 64), 5 * (i / 64), 128, 255}) {
      image.pixels.push_back(static_cast<std::uint8_t>(value));
    }
  }
  const Decoded jpeg = decoded(encode_jpeg(image));
  ASSERT_NE(jpeg.pixels, nullptr);
  EXPECT_EQ(jpeg.width, 64);
  EXPECT_EQ(jpeg.height, 48);
  int worst = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    worst = std::max(worst, std::abs(int{image.pixels[i]} - int{jpeg.pixels.get()[i]}));
  }
  EXPECT_LE(worst, 16);  // of 255; a smooth image at the quality of 88
  EXPECT_THROW(encode_jpeg({}), InvalidInput);
  EXPECT_THROW(encode_jpeg(image, 0), InvalidInput);
}

TEST(Image, DecodesWhatItEncodes) {
  const Image image = gradient(37, 23);
  EXPECT_EQ(decode_image(encode_png(image)), image);
  const Image jpeg = decode_image(encode_jpeg(image));
  EXPECT_EQ(jpeg.width, 37);
  EXPECT_EQ(jpeg.height, 23);
  EXPECT_THROW(decode_image(""), InvalidInput);
  EXPECT_THROW(decode_image("P6 2 2 255 "), InvalidInput);
  const std::string png = encode_png(image);
  EXPECT_THROW(decode_image(png.substr(0, png.size() / 2)), InvalidInput);
}

TEST(Image, SideBySideKeepsThePixels) {
  const Image left = gradient(5, 8);
  const Image right = gradient(3, 4);
  const Image row = side_by_side(std::array{left, right});
  EXPECT_EQ(row.width, 8);
  EXPECT_EQ(row.height, 8);
  EXPECT_EQ(at(row, 4, 7).green, at(left, 4, 7).green);
  EXPECT_EQ(at(row, 5, 2).blue, at(right, 0, 0).blue);
  EXPECT_THROW(side_by_side({}), InvalidInput);
}

TEST(Camera, FitShowsTheWholeBox) {
  const Box box{{-1, 2, 5}, {4, 3, 9}};
  for (const Projection projection : {Projection::orthographic, Projection::perspective}) {
    const Camera camera = fit_camera(box, {1, -2, 0.5}, {0, 0, 1}, 1.5, {projection, 40, 0.05});
    const CameraFrame frame = camera_frame(camera);
    const double distance = norm(camera.target - camera.eye);
    double widest = 0;
    for (int i = 0; i < 8; ++i) {
      const Vec3d corner{(i & 1) != 0 ? box.min.x : box.max.x, (i & 2) != 0 ? box.min.y : box.max.y,
                         (i & 4) != 0 ? box.min.z : box.max.z};
      const Vec3d d = corner - camera.eye;
      const double scale = projection == Projection::perspective ? distance / dot(d, frame.forward) : 1;
      widest = std::max({widest, 2 * scale * std::abs(dot(d, frame.up)) / camera.height,
                         2 * scale * std::abs(dot(d, frame.right)) / (1.5 * camera.height)});
    }
    EXPECT_NEAR(widest, 0.9, 1e-9);
  }
}

TEST(Camera, UpAlongTheViewIsReplaced) {
  const Camera camera = fit_camera({}, {0, 0, -1}, {0, 0, 1}, 1);
  const CameraFrame frame = camera_frame(camera);
  EXPECT_NEAR(norm(frame.right), 1, 1e-12);
  EXPECT_NEAR(dot(frame.up, frame.forward), 0, 1e-12);
}

}  // namespace
}  // namespace knead::render::render_test
