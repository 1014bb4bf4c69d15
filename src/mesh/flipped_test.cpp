// Flipped triangles after a deformation.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mesh/test_shapes.h"

namespace knead::flipped_test {
namespace {

TEST(CountFlipped, NoneWhereTheShapeIsMovedAsAWhole) {
  const Mesh torus = quad_torus(40, 20);
  std::vector<Vec3d> after = torus.positions;
  EXPECT_EQ(count_flipped(torus, torus.positions, after), 0u);
  for (Vec3d& p : after) p = {p.y * 3, -p.x * 2, p.z + 5};
  EXPECT_EQ(count_flipped(torus, torus.positions, after), 0u);
}

TEST(CountFlipped, AFlapFoldedOverItsNeighbours) {
  // A flat 4 x 4 grid whose inner vertex is pushed across an edge: the triangle there turns over.
  Mesh grid;
  for (std::uint32_t y = 0; y < 5; ++y) {
    for (std::uint32_t x = 0; x < 5; ++x) grid.positions.push_back({double(x), double(y), 0});
  }
  for (std::uint32_t y = 0; y < 4; ++y) {
    for (std::uint32_t x = 0; x < 4; ++x) {
      const std::uint32_t a = 5 * y + x;
      grid.add_face(std::array{a, a + 1, a + 6});
      grid.add_face(std::array{a, a + 6, a + 5});
    }
  }
  std::vector<Vec3d> after = grid.positions;
  after[12] = {3.2, 2.5, 0};
  std::size_t expected = 0;  // in a plane, turned over is facing down
  for (const Triangle& t : triangulate(grid)) {
    expected += cross(after[t[1]] - after[t[0]], after[t[2]] - after[t[0]]).z < 0 ? 1 : 0;
  }
  EXPECT_EQ(expected, 1u);
  EXPECT_EQ(count_flipped(grid, grid.positions, after), expected);
  EXPECT_EQ(count_flipped(grid, after, after), 0u);
  EXPECT_EQ(count_flipped(grid, after, grid.positions), 0u);
}

// Counts by the definition, with the normals of all vertices.
std::size_t flipped_by_definition(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  const auto opposes = [&](const Triangle& t, std::span<const Vec3d> positions, const std::vector<Vec3d>& normals) {
    const Vec3d normal = cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
    return dot(normal, normals[t[0]] + normals[t[1]] + normals[t[2]]) < 0;
  };
  const std::vector<Vec3d> normals_before = vertex_normals(mesh, before);
  const std::vector<Vec3d> normals_after = vertex_normals(mesh, after);
  std::size_t count = 0;
  for_each_triangle(mesh, before, [&](const Triangle& t) {
    count += opposes(t, after, normals_after) && !opposes(t, before, normals_before) ? 1 : 0;
  });
  return count;
}

// Gentle and wild motions of triangles and quads, of tiny and huge shapes too, with some vertices that coincide.
TEST(CountFlipped, AsDefinedHoweverMuchMoves) {
  std::mt19937 random(1);
  std::normal_distribution<double> number;
  for (const Mesh& mesh :
       {quad_torus(40, 20), make_shape(ShapeKind::sphere, 2000), make_shape(ShapeKind::knot, 2000)}) {
    std::size_t flipped = 0;
    for (const double size : {1e-90, 1e-40, 1.0, 1e70}) {
      for (const double motion : {0.001, 0.02, 0.05, 0.1, 1.0}) {
        std::vector<Vec3d> before = mesh.positions;
        for (Vec3d& p : before) p *= size;
        std::vector<Vec3d> after = before;
        for (Vec3d& p : after) {
          for (std::size_t k = 0; k < 3; ++k) p[k] += size * motion * number(random);
        }
        after[7] = after[8];
        before[9] = before[10];
        const std::size_t expected = flipped_by_definition(mesh, before, after);
        EXPECT_EQ(count_flipped(mesh, before, after), expected) << size << " " << motion;
        flipped += expected;
      }
    }
    EXPECT_GT(flipped, 1000u);
  }
}

TEST(CountFlipped, WhatIsNoNumberIsNotFlipped) {
  const Mesh torus = quad_torus(40, 20);
  std::vector<Vec3d> after = torus.positions;
  after[5].x = std::nan("");
  after[50].y = HUGE_VAL;
  EXPECT_EQ(count_flipped(torus, torus.positions, after), flipped_by_definition(torus, torus.positions, after));
}

}  // namespace
}  // namespace knead::flipped_test
