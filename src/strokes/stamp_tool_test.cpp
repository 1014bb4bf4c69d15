// The mesh of a stamp: its pose, depths inside it, and its widths.
#include "strokes/stamp.h"

#include <gtest/gtest.h>

#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::stamp_tool_test {
namespace {

// The sphere of radius 0.5 about that place.
Mesh ball_at(const Vec3d& place) {
  Mesh mesh = make_shape(ShapeKind::sphere, 2562);
  for (Vec3d& p : mesh.positions) p = place + p * 0.5;
  return mesh;
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  for (std::size_t f = 0; f < b.face_count(); ++f) {
    std::vector<std::uint32_t> face(b.face(f).begin(), b.face(f).end());
    for (std::uint32_t& v : face) v += static_cast<std::uint32_t>(a.vertex_count());
    mesh.add_face(face);
  }
  return mesh;
}

// The bar reaches from -3 to 3 and -0.5 to 0.5.
TEST(StampTool, KnowsTheWayOut) {
  const StampTool bar(make_shape(ShapeKind::box), Mat3d{});
  const auto front = bar.front({1, 0.1, 0.2}, {0, 0, -1});
  ASSERT_TRUE(front);
  EXPECT_NEAR(front->need, 0.7, 1e-12);
  EXPECT_NEAR(dot(front->normal, {0, 0, -1}), 1, 1e-12);
  EXPECT_FALSE(bar.front({1, 0.1, 0.7}, {0, 0, -1}));
  EXPECT_NEAR(bar.depth({1, 0.1, 0.2}), 0.3, 1e-12);
  EXPECT_EQ(bar.depth({1, 0.1, 0.7}), 0);
  EXPECT_NEAR(dot(bar.nearest_normal({1, 0.1, 0.2}), {0, 0, 1}), 1, 1e-12);
}

TEST(StampTool, IsPosed) {
  const Mat3d quarter_turn_and_half_size{{0, -0.5, 0}, {0.5, 0, 0}, {0, 0, 0.5}};
  const StampTool bar(make_shape(ShapeKind::box), quarter_turn_and_half_size);
  EXPECT_NEAR(bar.box().max.y, 1.5, 1e-12);
  EXPECT_NEAR(bar.box().max.x, 0.25, 1e-12);
  EXPECT_NEAR(bar.front({0, 1, 0}, {0, 1, 0})->need, 0.5, 1e-12);
}

// Two balls that overlap are one solid: the way out of it ends where both are left.
TEST(StampTool, MayPassThroughItself) {
  const StampTool pair(joined(ball_at({0, 0, 0}), ball_at({0.6, 0, 0})), Mat3d{});
  EXPECT_NEAR(pair.front({0.3, 0, 0}, {1, 0, 0})->need, 0.8, 2e-3);
  EXPECT_NEAR(pair.front({-0.3, 0, 0}, {1, 0, 0})->need, 1.4, 2e-3);
}

// Largest width of the bar across x: its cross-section's diagonal; across z: nearly its length.
TEST(StampTool, MeasuresItsWidth) {
  const StampTool bar(make_shape(ShapeKind::box), Mat3d{});
  EXPECT_NEAR(bar.half_width({1, 0, 0}), std::sqrt(0.5), 2e-4);
  EXPECT_NEAR(bar.half_width({0, 0, 1}), std::sqrt(9.25), 1e-3);
  EXPECT_NEAR(StampTool(ball_at({0, 0, 0}), Mat3d{}).half_width({0, 1, 0}), 0.5, 1e-3);
}

// A bar is as narrow as its short side, to the 1.2 that the directions leave and less at its corners.
TEST(StampTool, MeasuresHowNarrowItIs) {
  const double bar = StampTool(make_shape(ShapeKind::box), Mat3d{}).narrowest_width({0, 0, -1}, 0.03);
  EXPECT_GT(bar, 0.6);
  EXPECT_LT(bar, 1.2);
  const double letter = StampTool(make_shape(ShapeKind::letter_y, 5000), Mat3d{}).narrowest_width({0, 0, -1}, 0.03);
  EXPECT_GT(letter, 0.1);
  EXPECT_LT(letter, 0.21);
}

std::string refusal(const Mesh& mesh) {
  try {
    const StampTool tool(mesh, Mat3d{});
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

TEST(StampTool, RefusesWhatIsNoSolid) {
  const Mesh ball = ball_at({0, 0, 0});
  Mesh open = ball;
  open.corner_vertex.resize(open.corner_vertex.size() - 3);
  open.face_begin.pop_back();
  EXPECT_EQ(refusal(open), "\"mesh\" must be a closed surface, and this has 3 boundary edges; close its holes");
  Mesh inward = ball;
  for (std::size_t f = 0; f < inward.face_count(); ++f)
    std::swap(inward.corner_vertex[3 * f], inward.corner_vertex[3 * f + 1]);
  EXPECT_EQ(refusal(inward).substr(0, 48), "\"mesh\" must have faces that look outward, and th");
  Mesh torn = ball;
  std::swap(torn.corner_vertex[0], torn.corner_vertex[1]);
  EXPECT_EQ(refusal(torn).substr(0, 48), "\"mesh\" must have faces that look outward, and al");
  Mesh cloud;
  cloud.positions = ball.positions;
  EXPECT_EQ(refusal(cloud), "\"mesh\" must be a closed surface, and this has no faces");
}

}  // namespace
}  // namespace knead::detail::stamp_tool_test
