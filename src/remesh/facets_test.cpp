// Parts as CAD programs make them: flat faces of few, thin triangles.
#include "remesh/facets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/mesh.h"
#include "knead/remesh.h"
#include "mesh/test_shapes.h"
#include "support/deformed.h"

namespace knead::facets_test {
namespace {

constexpr double kThinAngle = 3;  // degrees, that of kMinReliableQuality

using test::crossings_as_float;
using test::Deformed;

Mesh in_triangles(const Mesh& mesh) {
  Mesh result;
  result.positions = mesh.positions;
  for (const Triangle& t : triangulate(mesh)) result.add_face(t);
  return result;
}

// A plate of 12 triangles, 120 x 20 x 4, as large as said, turned and moved, with coordinates rounded to float as in
// STL.
Mesh plate(double size = 1) {
  Mesh mesh = in_triangles(prism({{-60, -10, 0}, {60, -10, 0}, {60, 10, 0}, {-60, 10, 0}}));
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  for (Vec3d& p : mesh.positions) {
    p.z *= 4;
    const Vec3d q = size * Vec3d{c * p.x - s * p.y + 30, s * p.x + c * p.y, p.z};
    p = {static_cast<float>(q.x), static_cast<float>(q.y * c - q.z * s), static_cast<float>(q.y * s + q.z * c)};
  }
  return mesh;
}

// A bar along x with round sides of 40 narrow strips.
Mesh round_bar() {
  std::vector<Vec3d> outline;
  for (int i = 0; i < 40; ++i) {
    const double angle = 2 * std::numbers::pi * i / 40;
    outline.push_back({2 * std::cos(angle), 2 * std::sin(angle), 0});
  }
  Mesh mesh = in_triangles(prism(outline));
  for (Vec3d& p : mesh.positions) p = {30 * p.z, p.x, p.y};
  return mesh;
}

double distance(const Mesh& from, const Mesh& to) {
  const SurfaceTree tree(triangulate(to), to.positions);
  double most = 0;
  for (const Vec3d& p : from.positions) most = std::max(most, tree.closest(p)->distance);
  for (const Triangle& t : triangulate(from)) {
    const Vec3d center = (from.positions[t[0]] + from.positions[t[1]] + from.positions[t[2]]) / 3.0;
    most = std::max(most, tree.closest(center)->distance);
  }
  return most;
}

double smallest_angle(const Mesh& mesh) {
  Remeshed all;
  all.mesh = mesh;
  all.moved.assign(mesh.vertex_count(), true);
  return test::smallest_moved_angle(all);
}

TEST(FlatFaces, EverySharpEdgeOfAPlateIsACrease) {
  const Mesh mesh = plate();
  EXPECT_EQ(mesh.face_count(), 12U);
  EXPECT_EQ(find_creases(mesh).size(), 12U);
  EXPECT_EQ(find_creases(unit_cube()).size(), 12U);
  const Mesh wedge = prism({{0, 0, 0}, {3, 0, 0}, {0, 1, 0}});  // its ends are single triangles
  EXPECT_EQ(find_creases(wedge).size(), 9U);
}

TEST(FlatFaces, TheStripsOfARoundBarMeetAtCreases) {
  EXPECT_EQ(find_creases(round_bar()).size(), 120U);      // of 9 degrees along it, and two rims
  EXPECT_TRUE(find_creases(quad_torus(24, 12)).empty());  // its quadrilaterals are flat, too, but of a curved grid
}

TEST(FlatFaces, RemeshingAloneKeepsThemAndRepairsThinTriangles) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    const Mesh mesh = plate(size);
    const double diagonal = bounding_box(mesh.positions).diagonal();
    EXPECT_LT(smallest_angle(mesh), 2.5);
    for (const double max_edge : {0.0, 0.02, 0.3}) {
      RemeshSettings settings;
      if (max_edge > 0) settings.max_edge = max_edge * diagonal;
      const Remeshed result = remesh(mesh, settings);
      EXPECT_GT(smallest_angle(result.mesh), kThinAngle) << max_edge;
      EXPECT_LT(distance(result.mesh, mesh), 1e-6 * diagonal);
      EXPECT_LT(distance(mesh, result.mesh), 1e-6 * diagonal);
      EXPECT_LT(result.counts.distance, 1e-6 * diagonal);
      EXPECT_NEAR(measure(result.mesh).volume / measure(mesh).volume, 1, 1e-6);
      EXPECT_TRUE(measure(result.mesh).closed());
      for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(result.mesh.positions[v], mesh.positions[v]);
      EXPECT_EQ(crossings_as_float(result.mesh), 0U);
    }
  }
}

TEST(FlatFaces, RemeshingAloneKeepsNarrowStripsAndRims) {
  const Mesh mesh = round_bar();
  const Remeshed result = remesh(mesh, {});
  EXPECT_LT(distance(result.mesh, mesh), 1e-12);
  EXPECT_LT(distance(mesh, result.mesh), 1e-12);
  EXPECT_TRUE(measure(result.mesh).closed());
  EXPECT_EQ(crossings_as_float(result.mesh), 0U);
  EXPECT_NEAR(measure(result.mesh).volume / measure(mesh).volume, 1, 1e-12);
}

TEST(FlatFaces, RefiningADenseDiscTakesFewAndGoodTriangles) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    std::vector<Vec3d> outline;
    for (int i = 0; i < 400; ++i) {
      const double angle = 2 * std::numbers::pi * i / 400;
      outline.push_back(size * Vec3d{10 * std::cos(angle), 10 * std::sin(angle), 0});
    }
    Mesh disc = in_triangles(prism(outline));
    for (Vec3d& p : disc.positions) p.z *= 2 * size;
    RemeshSettings settings;
    settings.max_edge = 2 * size;
    settings.iterations = 0;
    const Remeshed result = remesh(disc, settings);
    EXPECT_LT(result.mesh.face_count(), 8000U);
    EXPECT_GT(smallest_angle(result.mesh), kThinAngle);
    EXPECT_LT(distance(result.mesh, disc), 1e-12 * size * 20);
    EXPECT_LT(distance(disc, result.mesh), 1e-12 * size * 20);
    EXPECT_TRUE(measure(result.mesh).closed());
    EXPECT_TRUE(result.counts.complete);
    for (std::size_t v = 0; v < disc.vertex_count(); ++v) {
      ASSERT_EQ(result.mesh.positions[v], disc.positions[v]);
    }
  }
}

TEST(FlatFaces, RemeshingAloneMovesACurvedSurfaceOnlyWhereThatIsAskedFor) {
  Mesh ball = make_shape(ShapeKind::sphere, 2000);
  for (Vec3d& p : ball.positions) {
    p = normalized(Vec3d{p.x, p.y, 0.1 * p.z});  // thin triangles near the equator
    p.z = std::max(p.z, -0.9);                   // and one flat face
  }
  const double diagonal = bounding_box(ball.positions).diagonal();
  EXPECT_LT(remesh(ball, {}).counts.distance, 1e-6 * diagonal);
  RemeshSettings settings;
  settings.max_chord = kDefaultMaxChord;
  const Remeshed moved = remesh(ball, settings);
  EXPECT_GT(moved.counts.distance, 1e-5 * diagonal);
  EXPECT_LT(moved.counts.distance, 1e-2 * diagonal);
  EXPECT_GT(moved.counts.flips, 100U);
}

// How far the middles of edges and faces are from the true image is only asked of the vertices and middles of faces.
void expect_exact_image(const Mesh& part, const Stroke& stroke) {
  const Deformed deformed(part, stroke);
  const Remeshed result = deformed.remeshed();
  const double diagonal = bounding_box(part.positions).diagonal();
  EXPECT_TRUE(result.counts.complete);
  EXPECT_EQ(crossings_as_float(result.mesh), 0U);
  EXPECT_NEAR(measure(result.mesh).volume / measure(part).volume, 1, 1e-3);
  EXPECT_TRUE(measure(result.mesh).closed());
  Mesh back = result.mesh;
  AdvectOptions exact;
  exact.precision = Precision::float64;
  exact.tolerance = 1e-9 * diagonal;
  advect(inverse(deformed.flow()), back.positions, exact);
  EXPECT_LT(distance(back, part), 5e-4 * diagonal);
}

TEST(FlatFaces, AreFollowedExactlyByTheirFewTriangles) {
  BendStroke bend;
  bend.center = {0, 0, 0};
  bend.axis = {0, 1, 0};
  bend.normal = {-1, 0, 0};
  bend.angle_deg = 90;
  bend.extent = BendWidth{40};
  const Mesh flat = in_triangles(prism({{-60, -10, 0}, {60, -10, 0}, {60, 10, 0}, {-60, 10, 0}}));
  expect_exact_image(flat, bend);
  expect_exact_image(flat, TwistStroke{{0, 0, 0}, {1, 0, 0}, 1.5, -60, 60});
  Mesh bar = round_bar();
  for (Vec3d& p : bar.positions) p.x -= 15;
  bend.extent = BendWidth{20};
  expect_exact_image(bar, bend);
}

// The upright edges of its wall stay straight under the bend, but points slide along them.
TEST(FlatFaces, AWallIsNotSplitAcrossEdgesThatStayStraight) {
  std::vector<Vec3d> outline;
  for (int i = 0; i < 96; ++i) {
    const double angle = 2 * std::numbers::pi * i / 96;
    outline.push_back({10 * std::cos(angle), 10 * std::sin(angle), 0});
  }
  Mesh disc = in_triangles(prism(outline));
  for (Vec3d& p : disc.positions) p.z *= 4;
  CurveStroke curve;
  curve.from = {{-10, 0, 2}, {10, 0, 2}};
  curve.axis = {0, 1, 0};
  curve.angle_deg = 10;
  expect_exact_image(disc, curve);
  const Deformed deformed(disc, curve);
  Mesh back = deformed.remeshed().mesh;
  AdvectOptions options;
  options.tolerance = 1e-6;
  advect(inverse(deformed.flow()), back.positions, options);
  EXPECT_GT(back.vertex_count(), 192U) << "the flat faces are split";
  const auto within = [](const Vec3d& p) { return p.z > 0.1 && p.z < 3.9; };
  EXPECT_EQ(std::count_if(back.positions.begin(), back.positions.end(), within), 0);
}

// Nearly all of its vertices lie on creases, where none may give back the volume that chords miss.
TEST(FlatFaces, AnOpenRingKeepsItsVolume) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    std::vector<Vec3d> outline;
    for (const double radius : {10.0, 9.0}) {
      for (int i = 0; i < 32; ++i) {
        const double angle = 0.2 + (2 * std::numbers::pi - 0.4) * (radius > 9 ? i : 31 - i) / 31;
        outline.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
      }
    }
    Mesh ring = in_triangles(prism(outline));
    for (Vec3d& p : ring.positions) p = size * Vec3d{p.x, p.y, 3 * p.z};
    CurveStroke curve;
    curve.from = {{-10 * size, 0, 1.5 * size}, {10 * size, 0, 1.5 * size}};
    curve.axis = {0, 1, 0};
    curve.angle_deg = 20;
    const Mesh bent = Deformed(ring, curve).remeshed().mesh;
    EXPECT_NEAR(measure(bent).volume / measure(ring).volume, 1, 1e-9);
  }
}

// A plate with a fine semicircular notch: the notch keeps its narrow strips, and the flat faces get good triangles,
// although the fine edges lie opposite to a long one.
TEST(FlatFaces, ANotchKeepsItsStripsAndTheFacesAroundItGetGoodTriangles) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    std::vector<Vec3d> outline{{-60, -10, 0}, {60, -10, 0}, {60, 10, 0}};
    for (int i = 0; i <= 128; ++i) {
      const double angle = std::numbers::pi * i / 128;
      outline.push_back({5 * std::cos(angle), 10 - 5 * std::sin(angle), 0});
    }
    outline.push_back({-60, 10, 0});
    Mesh part = in_triangles(prism(outline));
    for (Vec3d& p : part.positions) p = size * Vec3d{p.x, p.y, 4 * p.z};
    CurveStroke curve;
    curve.from = {{-60 * size, 0, 2 * size}, {60 * size, 0, 2 * size}};
    curve.axis = {0, 1, 0};
    curve.angle_deg = size == 1 ? 2 : 20;
    const Deformed deformed(part, curve);
    const Mesh bent = deformed.remeshed().mesh;
    Mesh back = bent;
    AdvectOptions options;
    options.tolerance = 1e-6 * size;
    advect(inverse(deformed.flow()), back.positions, options);
    const auto is_within = [&](const Vec3d& p) {
      return p.z > 0.1 * size && p.z < 3.9 * size && norm(Vec3d{p.x, p.y - 10 * size, 0}) < 6 * size;
    };
    EXPECT_EQ(std::count_if(back.positions.begin(), back.positions.end(), is_within), 0);
    for (const Vec3d& p : part.positions) {
      const auto is_there = [&](const Vec3d& q) { return norm(p - q) < 1e-3 * size; };
      ASSERT_TRUE(std::any_of(back.positions.begin(), back.positions.end(), is_there)) << p.x << " " << p.y;
    }
    Remeshed flat;
    for (const Triangle& t : triangulate(bent)) {
      const auto is_at = [&](double z) {
        return std::all_of(t.begin(), t.end(),
                           [&](auto v) { return std::abs(back.positions[v].z - z * size) < 0.1 * size; });
      };
      if (is_at(0) || is_at(4)) flat.mesh.add_face(t);
    }
    flat.mesh.positions = bent.positions;
    flat.moved.assign(bent.vertex_count(), true);
    EXPECT_GT(test::smallest_moved_angle(flat), 5);
    EXPECT_LT(bent.face_count(), 4000U);
  }
}

}  // namespace
}  // namespace knead::facets_test
