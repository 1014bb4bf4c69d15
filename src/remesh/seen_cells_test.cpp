// The scaled Jacobians of cells and their gradients, as functions of one vertex.
#include "remesh/vertex_star.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "knead/cells.h"
#include "knead/mesh.h"

namespace knead::detail::seen_cells_test {
namespace {

class Corners {
 public:
  Vec3d next() { return {normal_(random_), normal_(random_), normal_(random_)}; }

 private:
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
};

// Compares the gradient with differences of the value.
template <class Seen>
void expect_slant(const Seen& seen, const Vec3d& place) {
  constexpr double h = 1e-6;
  const LinearApproximation linear = seen.linear(place);
  EXPECT_EQ(linear.value, seen.quality(place));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d up = place;
    Vec3d down = place;
    up[axis] += h;
    down[axis] -= h;
    const double expected = (seen.quality(up) - seen.quality(down)) / (2 * h);
    EXPECT_NEAR(linear.gradient[axis], expected, 1e-5 * (1 + std::abs(expected)));
  }
}

TEST(SeenCells, TetrahedraHaveTheirScaledJacobian) {
  Corners corners;
  for (int i = 0; i < 100; ++i) {
    const std::array p{corners.next(), corners.next(), corners.next(), corners.next()};
    const double expected = cell_quality(CellKind::tetrahedron, p).scaled_jacobian;
    const SeenTetrahedron seen({p[1], p[2], p[3]}, std::sqrt(2.0));
    EXPECT_NEAR(seen.quality(p[0]), expected, 1e-12);
    expect_slant(seen, p[0]);
    // Of an inside-out cell the negative; its least corner is another one.
    const std::array turned{p[0], p[2], p[1], p[3]};
    const double of_turned = cell_quality(CellKind::tetrahedron, turned).scaled_jacobian;
    const SeenTetrahedron inside_out({p[1], p[2], p[3]}, -std::sqrt(2.0));
    EXPECT_NEAR(inside_out.quality(p[0]), of_turned, 1e-12);
    expect_slant(inside_out, p[0]);
  }
}

TEST(SeenCells, CornersAreTheDeterminantOverTheLengths) {
  Corners corners;
  for (int i = 0; i < 100; ++i) {
    const Vec3d o = corners.next();
    const std::array p{corners.next(), corners.next(), corners.next()};
    const double lengths = norm(p[0] - o) * norm(p[1] - o) * norm(p[2] - o);
    const double expected = -2 * dot(cross(p[0] - o, p[1] - o), p[2] - o) / lengths;
    const SeenCorner own = SeenCorner::of_vertex(p, -2);
    EXPECT_NEAR(own.quality(o), expected, 1e-12);
    expect_slant(own, o);
    for (std::size_t k = 0; k < 3; ++k) {
      const SeenCorner other = SeenCorner::beside(o, p[(k + 1) % 3], p[(k + 2) % 3], -2);
      EXPECT_NEAR(other.quality(p[k]), expected, 1e-12);
      expect_slant(other, p[k]);
    }
  }
}

TEST(SeenCells, AreZeroWithoutEdges) {
  const Vec3d o{1, 2, 3};
  EXPECT_EQ(SeenTetrahedron({o, o, o}, 1).linear(o).value, 0);
  EXPECT_EQ(SeenCorner::of_vertex({o, o, o}, 1).linear(o).value, 0);
  EXPECT_EQ(SeenCorner::beside(o, o, o, 1).linear(o).value, 0);
}

}  // namespace
}  // namespace knead::detail::seen_cells_test
