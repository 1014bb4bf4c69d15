#include "knead/mesh/flipped.h"

#include <gtest/gtest.h>

#include "knead/mesh/test_shapes.h"
#include "knead/mesh/triangulate.h"

namespace knead {
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

}  // namespace
}  // namespace knead
