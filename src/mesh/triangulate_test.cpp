// Triangles of polygons: convex, concave and crossing ones.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "knead/error.h"
#include "mesh/test_shapes.h"

namespace knead::triangulate_test {
namespace {

double shoelace(const std::vector<Vec3d>& outline) {
  double area2 = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3d& a = outline[i];
    const Vec3d& b = outline[(i + 1) % outline.size()];
    area2 += a.x * b.y - a.y * b.x;
  }
  return area2 / 2;
}

double sum_of_areas(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : triangulate(mesh)) {
    const auto& p = mesh.positions;
    sum += norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 2;
  }
  return sum;
}

// Star-shaped outlines with random radii: concave, never self-crossing.
std::vector<Vec3d> random_star(std::mt19937& random, std::size_t corners) {
  std::vector<Vec3d> outline;
  for (std::size_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners);
    const double radius = 0.2 + static_cast<double>(random() % 1000) / 1000;
    outline.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  return outline;
}

TEST(Triangulate, ConcavePolygonsAreCoveredOnce) {
  std::mt19937 random(7);
  for (std::size_t corners = 4; corners < 60; ++corners) {
    const std::vector<Vec3d> outline = random_star(random, corners);
    const Mesh mesh = prism(outline);
    const Measures m = measure(mesh);
    const double area = shoelace(outline);
    EXPECT_NEAR(m.volume, area, 1e-12 * area * static_cast<double>(corners)) << corners;
    double sides = 0;
    for (std::size_t i = 0; i < corners; ++i) sides += norm(outline[(i + 1) % corners] - outline[i]);
    EXPECT_NEAR(m.area, 2 * area + sides, 1e-12 * m.area * static_cast<double>(corners)) << corners;
  }
}

TEST(Triangulate, EveryPlaneAndEitherSide) {
  const std::vector<Vec3d> outline{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  for (int turn = 0; turn < 3; ++turn) {
    for (const double side : {1.0, -1.0}) {
      Mesh mesh;
      std::vector<std::uint32_t> face;
      for (const Vec3d& p : outline) {
        const Vec3d q{p.x, side * p.y, 0};
        mesh.positions.push_back(turn == 0 ? q : (turn == 1 ? Vec3d{q.z, q.x, q.y} : Vec3d{q.y, q.z, q.x}));
        face.push_back(static_cast<std::uint32_t>(face.size()));
      }
      mesh.add_face(face);
      EXPECT_EQ(triangulate(mesh).size(), 4u);
      EXPECT_NEAR(sum_of_areas(mesh), 4.0, 1e-14);
    }
  }
}

TEST(Triangulate, ADentedQuadIsCutAtItsDent) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}}, {{3, 0, 1, 2}});
  EXPECT_NEAR(sum_of_areas(mesh), 4.0, 1e-14);
}

TEST(Triangulate, APolygonWithABridgeToAHole) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}},
                              {{0, 1, 2, 3, 0, 4, 5, 6, 7, 4}});
  EXPECT_EQ(triangulate(mesh).size(), 8u);
  EXPECT_NEAR(sum_of_areas(mesh), 8.0, 1e-14);
}

TEST(Triangulate, NothingIsDroppedWhateverThePolygon) {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    Mesh mesh;
    std::vector<std::uint32_t> face;
    const std::size_t corners = 3 + random() % 20;
    for (std::size_t i = 0; i < corners; ++i) {
      mesh.positions.push_back({static_cast<double>(random() % 3), static_cast<double>(random() % 3), 0});
      face.push_back(static_cast<std::uint32_t>(random() % (i + 1)));
    }
    mesh.add_face(face);
    EXPECT_EQ(triangulate(mesh).size(), corners - 2);
    EXPECT_EQ(triangle_faces(mesh).size(), corners - 2);
  }
}

TEST(Triangulate, AHugeSpikyPolygonEndsInGoodTime) {
  Mesh mesh;
  std::vector<std::uint32_t> face;
  for (std::uint32_t i = 0; i < 60000; ++i) {
    mesh.positions.push_back({static_cast<double>((i * 7919u) % 60000u), static_cast<double>(i % 2), 0});
    face.push_back(i);
  }
  mesh.add_face(face);
  EXPECT_EQ(triangulate(mesh).size(), face.size() - 2);
}

TEST(Triangulate, FacesOfFewerThanThreeCornersHaveNone) {
  const Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1}, {0, 1, 2}, {2}});
  EXPECT_EQ(triangulate(mesh).size(), 1u);
  EXPECT_EQ(triangle_faces(mesh), std::vector<std::uint32_t>{1});
}

// Whoever takes triangles looks at them at the door.
TEST(Triangulate, TrianglesWithoutPlacesAreRefusedWithTheirNumber) {
  const std::vector<Vec3d> places{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  std::vector<Vec3d> lost = places;
  lost[1].z = std::nan("");
  const std::vector<Triangle> good{{0, 1, 2}};
  const std::vector<Triangle> beyond{{0, 1, 2}, {0, 3, 1}};
  const auto refusal = [](const auto& take) -> std::string {
    try {
      take();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_EQ(refusal([&] { check_triangles(good, places); }), "taken");
  const auto expect_all = [&](std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                              const std::string& what) {
    EXPECT_EQ(refusal([&] { check_triangles(triangles, positions); }), what);
    EXPECT_EQ(refusal([&] { self_intersections(triangles, positions); }), what);
    EXPECT_EQ(refusal([&] { SurfaceTree(triangles, positions); }), what);
  };
  expect_all(beyond, places, "triangle 1 uses vertex 3; there are 3, numbered from 0");
  expect_all(good, lost, "triangle 0 uses vertex 1, which has a coordinate that is not finite; place or remove it");
  Mesh mesh;
  mesh.positions = places;
  mesh.add_face(beyond[1]);
  EXPECT_NE(refusal([&] { measure(mesh); }), "taken");
}

}  // namespace
}  // namespace knead::triangulate_test
