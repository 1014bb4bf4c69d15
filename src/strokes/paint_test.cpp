// The tool "paint": dabs on a surface that moves, depths, pinches and refusals.
#include "knead/editor/tools.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "strokes/surface_finder.h"

namespace knead::paint_test {
namespace {

// A surface that moves as it is painted, and remembers how.
struct Canvas {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
  std::vector<PaintStroke> dabs;

  void paint(const PaintStroke& stroke, bool as_cloud = false, std::function<Vec3d(std::uint32_t)> normal = {}) {
    LiveSurface surface;
    surface.positions = positions;
    if (!as_cloud) surface.triangles = triangles;
    surface.normal = std::move(normal);
    surface.apply = [&](const Stroke& dab) {
      dabs.push_back(std::get<PaintStroke>(dab));
      AdvectOptions options;
      options.tolerance = 1e-6;
      options.precision = Precision::float64;
      advect(flow_of(dab), positions, options);
      return true;
    };
    paint_on(stroke, surface);
  }
};

Canvas canvas_of(const Mesh& mesh) { return {mesh.positions, triangulate(mesh), {}}; }

Canvas sphere(std::size_t vertices = 4000) { return canvas_of(make_shape(ShapeKind::sphere, vertices)); }

// A winding curve over the front of the unit sphere, off its surface here and there.
std::vector<Vec3d> winding(int points) {
  std::vector<Vec3d> path;
  for (int i = 0; i < points; ++i) {
    const double t = static_cast<double>(i) / (points - 1);
    const double azimuth = 1.5 * (t - 0.5);
    const double elevation = 0.35 * std::sin(3 * t);
    path.push_back(
        Vec3d{std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation)} *
        (1 + 0.03 * std::cos(5 * t)));
  }
  return path;
}

double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double greatest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) greatest = std::max(greatest, norm(a[i] - b[i]));
  return greatest;
}

// The finder follows what a dab moves. A dab in single precision moves what its rounding reaches, too.
TEST(Paint, EveryDabLiesOnTheSurfaceAsTheOneBeforeLeftIt) {
  for (const double depth : {0.4, -0.4}) {
    Canvas canvas = sphere();
    LiveSurface surface{canvas.positions, canvas.triangles, {}, {}};
    PaintStroke stroke;
    stroke.outer = 0.35;
    stroke.depth = depth;
    stroke.path = winding(20);
    const std::vector<Vec3d> aims = paint_dabs(stroke).aims;
    std::size_t dab = 0;
    surface.apply = [&](const Stroke& part) {
      const PaintSample expected = detail::SurfaceFinder(surface).closest(aims[dab++]).value();
      const PaintSample& found = std::get<PaintStroke>(part).samples.at(0);
      EXPECT_EQ(found.point, expected.point) << dab;
      EXPECT_EQ(found.normal, expected.normal) << dab;
      AdvectOptions options;
      options.tolerance = 1e-5;
      advect(flow_of(part), canvas.positions, options);
      return true;
    };
    paint_on(stroke, surface);
    EXPECT_EQ(dab, aims.size());
  }
}

// The bar: two in a hundred of the depth.
TEST(Paint, DoesNotDependOnHowDenselyThePathWasSampled) {
  for (const double depth : {0.05, -0.05, 0.2, -0.2}) {
    PaintStroke stroke;
    stroke.outer = 0.35;
    stroke.depth = depth;
    std::vector<std::vector<Vec3d>> results;
    for (const int points : {10, 47, 1000}) {
      stroke.path = winding(points);
      Canvas canvas = sphere();
      canvas.paint(stroke);
      results.push_back(canvas.positions);
    }
    EXPECT_LT(greatest_distance(results[0], results[2]), 0.02 * std::abs(depth)) << depth;
    EXPECT_LT(greatest_distance(results[1], results[2]), 0.02 * std::abs(depth)) << depth;
  }
}

TEST(Paint, OnePointIsADabOfFullDepthAtTheClosestPoint) {
  PaintStroke stroke;
  stroke.outer = 0.4;
  stroke.depth = 0.1;
  stroke.path = {{0, 0, 1.3}};
  Canvas canvas = sphere();
  canvas.paint(stroke);
  ASSERT_EQ(canvas.dabs.size(), 1u);
  EXPECT_EQ(canvas.dabs[0].depth, 0.1);
  EXPECT_LT(norm(canvas.dabs[0].samples[0].point - Vec3d{0, 0, 1}), 2e-3);  // the sphere's facets
  EXPECT_LT(norm(canvas.dabs[0].samples[0].normal - Vec3d{0, 0, 1}), 2e-3);
}

// Along the middle of a long straight path over a plate the surface goes down by the depth, and up where it is
// negative: the dabs add up to it in the limit of small depths (1% here), and nearly so for large ones.
TEST(Paint, AGrooveIsAsDeepAsAsked) {
  Mesh plate = make_shape(ShapeKind::box, 20000);
  for (Vec3d& p : plate.positions) p = {4 * p.x, 4 * p.y, p.z};
  const double top =
      std::max_element(plate.positions.begin(), plate.positions.end(), [](auto& a, auto& b) { return a.z < b.z; })->z;
  struct Case {
    double depth;
    double relative_error;
    int falloff = kDefaultFalloff;
  };
  for (const Case& c : {Case{0.01, 0.02}, Case{-0.01, 0.02}, Case{0.2, 0.15}, Case{-0.2, 0.15}, Case{0.01, 0.02, 3},
                        Case{0.01, 0.02, 5}, Case{0.01, 0.03, 6}, Case{0.01, 0.03, 7}}) {
    PaintStroke stroke;
    stroke.falloff = c.falloff;
    stroke.outer = 0.5;
    stroke.depth = c.depth;
    stroke.path = {{-1.2, 0, top}, {1.2, 0, top}};
    Canvas canvas = canvas_of(plate);
    canvas.paint(stroke);
    std::vector<double> heights;
    for (std::size_t i = 0; i < canvas.positions.size(); ++i) {
      const Vec3d& p = plate.positions[i];
      if (p.z > top - 1e-9 && std::abs(p.x) < 0.3 && std::abs(p.y) < 0.05) heights.push_back(canvas.positions[i].z);
    }
    ASSERT_FALSE(heights.empty());
    double mean = 0;
    for (const double z : heights) mean += z / static_cast<double>(heights.size());
    EXPECT_NEAR(top - mean, c.depth, c.relative_error * std::abs(c.depth)) << c.falloff;
  }
}

TEST(Paint, FollowsTheSurfaceAsItMoves) {
  PaintStroke stroke;
  stroke.outer = 0.4;
  stroke.depth = -0.1;
  stroke.path = {{0, 0, 1}, {0.01, 0, 1}};  // over nearly one place: many dabs, each on the bump of those before
  Canvas canvas = sphere();
  canvas.paint(stroke);
  ASSERT_GE(canvas.dabs.size(), 2u);
  for (std::size_t i = 1; i < canvas.dabs.size(); ++i) {
    EXPECT_GT(canvas.dabs[i].samples[0].point.z, canvas.dabs[i - 1].samples[0].point.z);
  }
}

TEST(Paint, ACloudWithNormalsIsPaintedAsItsSurface) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 16000);
  PaintStroke stroke;
  stroke.outer = 0.35;
  stroke.depth = 0.1;
  stroke.path = winding(20);
  Canvas surface = canvas_of(mesh);
  surface.paint(stroke);
  Canvas cloud = canvas_of(mesh);
  cloud.paint(stroke, true, [&](std::uint32_t v) { return vertex_normals(mesh, cloud.positions)[v]; });
  EXPECT_LT(greatest_distance(surface.positions, cloud.positions), 0.1 * stroke.depth);
}

TEST(Paint, RefusesWhatHasNoNormal) {
  PaintStroke stroke;
  stroke.outer = 0.35;
  stroke.depth = 0.1;
  stroke.path = winding(20);
  Canvas canvas = sphere(500);
  EXPECT_THROW(canvas.paint(stroke, true), InvalidInput);
  EXPECT_THROW(canvas.paint(stroke, true, [](std::uint32_t /*vertex*/) { return Vec3d{}; }), InvalidInput);
  stroke.outer = 1e-9;
  EXPECT_THROW(paint_dabs(stroke), InvalidInput);
}

TEST(Paint, StopsWhenTold) {
  Canvas canvas = sphere(500);
  PaintStroke stroke;
  stroke.outer = 0.35;
  stroke.depth = 0.1;
  stroke.path = winding(20);
  LiveSurface surface;
  surface.positions = canvas.positions;
  surface.triangles = canvas.triangles;
  int applied = 0;
  surface.apply = [&](const Stroke&) { return ++applied < 3; };
  paint_on(stroke, surface);
  EXPECT_EQ(applied, 3);
}

// A square sheet of side 2 in the plane z = 0.
Canvas sheet(int cells = 160) {
  Canvas canvas;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x) canvas.positions.push_back({2.0 * x / cells - 1, 2.0 * y / cells - 1, 0});
  }
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (cells + 1) + x); };
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      canvas.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      canvas.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  return canvas;
}

// Along the sheet's middle.
PaintStroke pinching(double bump, double pinch, double depth) {
  PaintStroke stroke;
  stroke.falloff = kWideFalloff;
  stroke.bump = bump;
  stroke.pinch = pinch;
  stroke.depth = depth;
  stroke.path = {{-0.6, 0, 0}, {0, 0, 0}, {0.6, 0, 0}};
  return stroke;
}

// The height of the sheet in the middle of the stroke, so far beside it.
double height_at(const Canvas& canvas, double beside) {
  const auto distance = [&](const Vec3d& p) { return std::hypot(p.x, p.y - beside); };
  return std::min_element(canvas.positions.begin(), canvas.positions.end(),
                          [&](const Vec3d& a, const Vec3d& b) { return distance(a) < distance(b); })
      ->z;
}

TEST(Paint, ACreaseIsAsDeepAsAskedAndSharperThanAGroove) {
  for (const double depth : {0.02, 0.05, -0.02, -0.05}) {
    Canvas crease = sheet();
    crease.paint(pinching(0.15, 1, depth));
    EXPECT_NEAR(height_at(crease, 0), -depth, 0.1 * std::abs(depth));
    Canvas groove = sheet();
    groove.paint(pinching(0.15, 0, depth));
    EXPECT_NEAR(height_at(groove, 0), -depth, 0.1 * std::abs(depth));
    // At a quarter of the bump.
    EXPECT_LT(std::abs(height_at(crease, 0.0375)), 0.75 * std::abs(height_at(groove, 0.0375))) << depth;
  }
}

TEST(Paint, APinchAloneDrawsAFlatSurfaceTogetherInItself) {
  Canvas canvas = sheet();
  const std::vector<Vec3d> before = canvas.positions;
  canvas.paint(pinching(0.15, 1, 0));
  double nearest = 1;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(canvas.positions[i].z, 0, 1e-9);
    if (std::abs(before[i].x) < 0.01 && before[i].y > 0)
      nearest = std::min(nearest, canvas.positions[i].y / before[i].y);
  }
  EXPECT_NEAR(nearest, std::exp(-1), 0.05) << "across the path by the logarithm";
}

TEST(Paint, FlatteningPassesNoPlaneAndLevelsWhatIsRough) {
  Canvas canvas = sheet();
  for (Vec3d& p : canvas.positions) p.z = 0.02 * std::sin(40 * p.x) * std::sin(40 * p.y);
  const std::vector<Vec3d> before = canvas.positions;
  canvas.paint(pinching(0.3, -1.5, 0));
  double greatest = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(std::abs(before[i].z) < 1e-3 || before[i].z * canvas.positions[i].z > -1e-6);
    if (std::hypot(before[i].x, before[i].y) < 0.1) greatest = std::max(greatest, std::abs(canvas.positions[i].z));
  }
  EXPECT_LT(greatest, 0.35 * 0.02);
}

TEST(Paint, APinchThatCannotBeIsRefused) {
  PaintStroke narrow = pinching(0.2, 1, 0);
  narrow.falloff = kDefaultFalloff;
  narrow.outer = 0.3;
  EXPECT_THROW(validate(Stroke(narrow)), InvalidInput);
  EXPECT_NO_THROW(validate(Stroke(pinching(0.2, 0.5, 0.04))));
  EXPECT_THROW(validate(Stroke(pinching(0.2, 0.5, 0.06))), InvalidInput) << "deeper than its centre can take it";
  EXPECT_THROW(validate(Stroke(pinching(0.2, 0, 0))), InvalidInput);
  EXPECT_THROW(validate(Stroke(pinching(0.2, 9, 0))), InvalidInput);
}

TEST(Paint, ThePinchNamesADepthThatWorks) {
  for (const double bump : {0.07, 0.11, 0.2, 0.31, 4.7}) {
    for (const double pinch : {0.3, -0.7, 1.3}) {
      try {
        validate(Stroke(pinching(bump, pinch, 9)));
        FAIL() << bump;
      } catch (const InvalidInput& error) {
        const std::string message = error.what();
        const double depth = std::stod(message.substr(message.find(" to ") + 4));
        EXPECT_NO_THROW(validate(Stroke(pinching(bump, pinch, depth)))) << message;
        EXPECT_NO_THROW(validate(Stroke(pinching(bump, pinch, -depth)))) << message;
        EXPECT_THROW(validate(Stroke(pinching(bump, pinch, 1.01 * depth))), InvalidInput) << message;
      }
    }
  }
}

}  // namespace
}  // namespace knead::paint_test
