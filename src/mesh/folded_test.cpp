// Folded edges: turns by more than 170 degrees.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "knead/mesh.h"
#include "mesh/test_shapes.h"

namespace knead::folded_test {
namespace {

// Two triangles with a common edge, the second turned about it: 0 degrees in one plane, 180 on top of each other.
Mesh hinge(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -std::cos(angle), std::sin(angle)}}, {{0, 1, 2}, {1, 0, 3}});
}

TEST(Folded, CountsTurnsByMoreThan170Degrees) {
  for (const double degrees : {0.0, 90.0, 169.9}) {
    EXPECT_EQ(count_folded_edges(hinge(degrees)), 0u) << degrees;
    EXPECT_EQ(count_folded_edges(hinge(-degrees)), 0u) << -degrees;
  }
  for (const double degrees : {170.1, 179.0, 180.0}) {
    EXPECT_EQ(count_folded_edges(hinge(degrees)), 1u) << degrees;
    EXPECT_EQ(count_folded_edges(hinge(-degrees)), 1u) << -degrees;
  }
}

TEST(Folded, LeavesOutWhatHasNoTurn) {
  Mesh misoriented = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 1, 3}});
  EXPECT_EQ(count_folded_edges(misoriented), 0u);
  Mesh three = hinge(180);
  three.positions.push_back({0, 0, 1});
  three.add_face(std::array{0u, 1u, 4u});
  EXPECT_EQ(count_folded_edges(three), 0u);
  EXPECT_EQ(count_folded_edges(make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}}, {{0, 1, 2}, {1, 0, 3}})), 0u);
}

TEST(Folded, OfSoundShapesAreNone) {
  EXPECT_EQ(count_folded_edges(unit_cube()), 0u);
  EXPECT_EQ(count_folded_edges(make_shape(ShapeKind::knot)), 0u);
}

// A vertex drawn across its opposite edge turns its triangles over.
TEST(Folded, FindsATriangleThatWasTurnedOver) {
  Mesh fan = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                       {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
  EXPECT_EQ(count_folded_edges(fan), 0u);
  fan.positions[0] = {2, 2, 0};
  EXPECT_EQ(count_folded_edges(fan), 2u);
}

}  // namespace
}  // namespace knead::folded_test
