// Pictures of splats, and that deformed splats look like splats of the deformed mesh.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "knead/editor/render.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "math/geometry.h"
#include "support/splat_scenes.h"

namespace knead::render::splats_test {
namespace {

constexpr std::size_t kSplats = 50'000;
constexpr double kApart = 8;  // dB: centres alone have at least six times the error

Options square(int size) {
  Options options;
  options.width = size;
  options.height = size;
  return options;
}

// One splat at the target of a camera that sees 2 units in 100 pixels.
Mesh one_splat(const std::array<double, 3>& sizes) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}};
  for (int i = 0; i < 3; ++i) add(mesh, fmt::format("scale_{}", i), {std::log(sizes[static_cast<std::size_t>(i)])});
  for (int i = 0; i < 4; ++i) add(mesh, fmt::format("rot_{}", i), {i == 0 ? 1.0 : 0.0});
  for (int i = 0; i < 3; ++i) add(mesh, fmt::format("f_dc_{}", i), {i == 0 ? 1.772 : -1.772});  // red
  add(mesh, "opacity", {0.0});
  return mesh;
}

TEST(SplatPicture, ASplatIsAGaussian) {
  const Mesh mesh = one_splat({0.2, 0.1, 0.05});
  const Camera camera{.projection = Projection::orthographic, .height = 2};
  Options options = square(100);
  options.background = {0, 0, 0, 1};
  const Image image = render_splats(mesh, camera, options);
  const auto red = [&](int x, int y) { return image.pixels[static_cast<std::size_t>(4 * (100 * y + x))] / 255.0; };
  for (const int d : {0, 5, 12, 20}) {  // pixels: a deviation is 10 or 5 of them, and 0.3 of a pixel's variance more
    const double across = (d + 0.5) * (d + 0.5) / 100.3 + 0.25 / 25.3;
    const double down = (d + 0.5) * (d + 0.5) / 25.3 + 0.25 / 100.3;
    EXPECT_NEAR(red(50 + d, 50), 0.5 * std::exp(-across / 2), 0.01) << d;
    EXPECT_NEAR(red(50, 50 + d), 0.5 * std::exp(-down / 2), 0.01) << d;
  }
}

TEST(SplatPicture, ASplitSplatLooksAsBefore) {
  for (const double logit : {-2.0, 0.0, 3.0, 6.0}) {
    Mesh mesh = one_splat({0.3, 0.1, 0.1});
    mesh.attributes.back().values = {logit};
    const ShapeFile source = parse_shape(serialize_mesh("ply", mesh), "ply", "one.ply");
    const Session session = parse_session(
        "{\"knead\": 1}\n{\"tool\": \"bend\", \"center\": [0, 0, 0], \"axis\": [0, 1, 0], \"normal\": [1, 0, 0], "
        "\"width\": 0.5, \"angle_deg\": 90}\n",
        "s.knead");
    ShapeFile split = source;
    ASSERT_TRUE(split_splats(split, session, {}, 100));
    ASSERT_GT(split.mesh.vertex_count(), 4U);
    const Camera camera{.projection = Projection::orthographic, .height = 2};
    const Options options = square(200);
    EXPECT_GT(psnr(error_of(render_splats(split.mesh, camera, options), render_splats(source.mesh, camera, options))),
              29)
        << logit;
  }
}

void apply(Mesh& mesh, const ChangedSplats& changed) {
  for (const Attribute& attribute : changed.attributes) {
    std::vector<double>& values = std::ranges::find(mesh.attributes, attribute.name, &Attribute::name)->values;
    for (std::size_t k = 0; k < changed.splats.size(); ++k) values[changed.splats[k]] = attribute.values[k];
  }
}

// The splats as the triangles take them: what a capture of the deformed mesh would hold.
Mesh cover_deformed(const Mesh& splats, const Mesh& before, const Mesh& after, std::span<const Triangle> triangles,
                    std::span<const Sample> samples) {
  Mesh result = splats;
  SplatJacobians jacobians;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const Triangle& t = triangles[samples[i].triangle];
    result.positions[i] = place_of(after, t, samples[i]);
    jacobians.splats.push_back(i);
    jacobians.jacobians.push_back(with_columns(frame_of(after, t)) * inverse(with_columns(frame_of(before, t))));
  }
  apply(result, deformed_splats(splats, jacobians));
  return result;
}

struct Made {
  const char* name;
  ShapeKind kind;
  const char* session;

  friend std::ostream& operator<<(std::ostream& out, const Made& made) { return out << made.name; }
};

class SplatScene : public testing::TestWithParam<Made> {};

TEST_P(SplatScene, LooksLikeSplatsOfTheDeformedMesh) {
  const Mesh mesh = make_shape(GetParam().kind, 60'000);
  const std::vector<Triangle> triangles = triangulate(mesh);
  const std::vector<Sample> samples = samples_of(mesh, triangles, kSplats);
  const Mesh splats = cover(mesh, triangles, samples);
  const Session session = parse_session(std::string("{\"knead\": 1}\n") + GetParam().session + "\n", "s.knead");
  const Mesh after = replay(borrow(mesh), session).shape.to_mesh();
  const Mesh deformed = replay(borrow(splats), session).shape.to_mesh();
  const Mesh expected = cover_deformed(splats, mesh, after, triangles, samples);
  Mesh centers_only = splats;
  centers_only.positions = deformed.positions;
  double error = 0;  // of ten views
  double error_of_centers = 0;
  for (int view = 0; view < 10; ++view) {
    const ViewDirection direction = view_direction(36 * view, view % 2 == 0 ? 20 : -30, false);
    const Camera camera = fit_points(expected.positions, direction.direction, direction.up, 1);
    const Options options = square(300);
    const Image picture = render_splats(expected, camera, options);
    error += error_of(render_splats(deformed, camera, options), picture) / 10;
    error_of_centers += error_of(render_splats(centers_only, camera, options), picture) / 10;
  }
  EXPECT_GT(psnr(error), 40);
  EXPECT_LT(psnr(error_of_centers), psnr(error) - kApart);
}

INSTANTIATE_TEST_SUITE_P(
    Made, SplatScene,
    testing::Values(
        Made{
            "sphere", ShapeKind::sphere,
            R"({"tool": "rotate", "center": [0.8, 0, 0], "axis": [1, 1, 0], "angle_deg": 60, "inner": 0.2, "outer": 1.4})"},
        Made{
            "bar", ShapeKind::box,
            R"({"tool": "bend", "center": [0, 0, 0], "axis": [0, 1, 0], "normal": [1, 0, 0], "width": 2, "angle_deg": 90})"},
        Made{
            "hand", ShapeKind::hand,
            R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 1, 0], "rate_deg": 90, "inner": -0.5, "outer": 0.5})"}),
    [](const auto& scene) { return std::string(scene.param.name); });

}  // namespace
}  // namespace knead::render::splats_test
