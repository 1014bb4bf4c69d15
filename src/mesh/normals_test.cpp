// Vertex normals, and authored normals and tangents after a deformation.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <random>

#include "mesh/test_shapes.h"

namespace knead::normals_test {
namespace {

// Turns about an axis through the origin.
Vec3d turned(const Vec3d& p, const Vec3d& axis, double angle) {
  return p * std::cos(angle) + cross(axis, p) * std::sin(angle) + axis * (dot(axis, p) * (1 - std::cos(angle)));
}

std::vector<Vec3d> random_normals(std::size_t count) {
  std::mt19937 random(11);
  std::normal_distribution<double> component;
  std::vector<Vec3d> normals;
  for (std::size_t i = 0; i < count; ++i) {
    normals.push_back(normalized(Vec3d{component(random), component(random), component(random)}));
  }
  return normals;
}

TEST(VertexNormals, OfATorusPointOutwards) {
  const Mesh torus = quad_torus(160, 80);
  const std::vector<Vec3d> normals = vertex_normals(torus);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vec3d& p = torus.positions[i];
    const double ring = std::sqrt(p.x * p.x + p.y * p.y);
    const Vec3d exact = (p - Vec3d{p.x / ring, p.y / ring, 0}) / 0.4;
    EXPECT_NEAR(norm(normals[i]), 1, 1e-14);
    EXPECT_NEAR(dot(normals[i], exact), 1, 1e-5);
  }
}

TEST(VertexNormals, OfACubeAreItsDiagonals) {
  const Mesh cube = unit_cube();
  const std::vector<Vec3d> normals = vertex_normals(cube);
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3d exact = normalized(cube.positions[i] - Vec3d{0.5, 0.5, 0.5});
    EXPECT_NEAR(norm(normals[i] - exact), 0, 1e-15);
  }
}

TEST(VertexNormals, AreZeroWhereUndefinedAtAnyScale) {
  const Mesh flat = make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 5, 5}}, {{0, 1, 2}, {1, 1, 2}});
  for (const Vec3d& n : vertex_normals(flat)) EXPECT_EQ(n, Vec3d{});
  for (const double scale : {1e-150, 1e-70, 1e70, 1e150}) {
    Mesh cube = unit_cube();
    for (Vec3d& p : cube.positions) p = p * scale;
    for (const Vec3d& n : vertex_normals(cube)) EXPECT_NEAR(norm(n), 1, 1e-14) << scale;
  }
}

TEST(TransportNormals, TurnWithARotation) {
  const Mesh torus = quad_torus(20, 12);
  const Vec3d axis = normalized(Vec3d{1, 2, 3});
  for (const double angle : {1e-6, 0.7, 3.0}) {
    Mesh after = torus;
    for (Vec3d& p : after.positions) p = turned(p, axis, angle);
    for (const std::vector<Vec3d>& normals : {vertex_normals(torus), random_normals(torus.vertex_count())}) {
      const std::vector<Vec3d> moved = transport_normals(torus, after.positions, normals, torus.corner_vertex);
      for (std::size_t i = 0; i < moved.size(); ++i)
        EXPECT_NEAR(norm(moved[i] - turned(normals[i], axis, angle)), 0, 1e-13);
    }
  }
}

TEST(TransportNormals, KeepTheirLengthAndTheirAngleToTheShape) {
  const Mesh torus = quad_torus(20, 12);
  const std::vector<Vec3d> authored = random_normals(torus.vertex_count());
  std::vector<Vec3d> after = torus.positions;
  for (Vec3d& p : after) p = {p.x, p.y * 2 + 0.3 * p.x * p.x, p.z + 0.5 * std::sin(3 * p.y)};
  const std::vector<Vec3d> moved = transport_normals(torus, after, authored, torus.corner_vertex);
  const std::vector<Vec3d> from = vertex_normals(torus);
  const std::vector<Vec3d> to = vertex_normals(torus, after);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_NEAR(norm(moved[i]), 1, 1e-13);
    EXPECT_NEAR(dot(moved[i], to[i]), dot(authored[i], from[i]), 1e-13);
  }
}

TEST(TransportNormals, KeepTheirBitsAwayFromWhatMoved) {
  const Mesh torus = quad_torus(20, 12);
  const std::vector<Vec3d> authored = random_normals(torus.vertex_count());
  std::vector<Vec3d> after = torus.positions;
  EXPECT_EQ(transport_normals(torus, after, authored, torus.corner_vertex), authored);
  after[0] += Vec3d{0.1, 0.05, 0.1};
  const std::vector<Vec3d> moved = transport_normals(torus, after, authored, torus.corner_vertex);
  std::vector<bool> near(torus.vertex_count(), false);
  for (std::size_t f = 0; f < torus.face_count(); ++f) {
    bool has_first = false;
    for (const std::uint32_t v : torus.face(f)) has_first = has_first || v == 0;
    for (const std::uint32_t v : torus.face(f)) near[v] = near[v] || has_first;
  }
  std::size_t changed = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_TRUE(near[i] || moved[i] == authored[i]) << i;
    changed += moved[i] == authored[i] ? 0 : 1;
  }
  EXPECT_GT(changed, 4u);
}

TEST(TransportNormals, HardEdgesStayHard) {
  Mesh cube = unit_cube();
  const std::vector<Vec3d> authored{{0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  std::vector<std::uint32_t> corner_normal;
  for (std::uint32_t f = 0; f < 6; ++f) corner_normal.insert(corner_normal.end(), 4, f);
  corner_normal[0] = kNoNormal;
  std::vector<Vec3d> sheared = cube.positions;
  for (Vec3d& p : sheared) p.x += p.z;
  const std::vector<Vec3d> moved = transport_normals(cube, sheared, authored, corner_normal);
  EXPECT_NEAR(norm(moved[1] - Vec3d{0, 0, 1}), 0, 1e-15);
  EXPECT_NEAR(norm(moved[3] - normalized(Vec3d{1, 0, -1})), 0, 1e-15);
  // Turned over as a whole: half a turn has no smallest axis, but the result is still the opposite.
  std::vector<Vec3d> over = cube.positions;
  for (Vec3d& p : over) p = {p.x, -p.y, -p.z};
  EXPECT_NEAR(norm(transport_normals(cube, over, authored, corner_normal)[1] - Vec3d{0, 0, -1}), 0, 1e-15);
}

// A tangent at each vertex: any direction orthogonal to the normal.
std::vector<Vec3d> tangents_across(const std::vector<Vec3d>& normals) {
  std::vector<Vec3d> tangents;
  for (const Vec3d& n : normals) tangents.push_back(any_orthogonal(n));
  return tangents;
}

TEST(TransportTangents, TurnWithARotation) {
  const Mesh torus = quad_torus(20, 12);
  const std::vector<Vec3d> normals = vertex_normals(torus);
  const std::vector<Vec3d> tangents = tangents_across(normals);
  const Vec3d axis = normalized(Vec3d{1, 2, 3});
  std::vector<Vec3d> after = torus.positions;
  for (Vec3d& p : after) p = turned(p, axis, 0.7) + Vec3d{3, 4, 5};
  std::vector<Vec3d> turned_normals;
  for (const Vec3d& n : normals) turned_normals.push_back(turned(n, axis, 0.7));
  const std::vector<Vec3d> moved = transport_tangents(torus, after, tangents, turned_normals);
  // Edges are about 0.2 long at coordinates of about 5: their differences carry some 30 roundings of 1e-16.
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_NEAR(norm(moved[i] - turned(tangents[i], axis, 0.7)), 0, 1e-13) << i;
  }
}

// Normals alone do not show a rotation about the normal.
TEST(TransportTangents, TurnAboutTheNormal) {
  const Mesh fan = make_mesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {-1, 0.5, 0}, {0, -1, 0}},
                             {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
  const std::vector<Vec3d> up(5, Vec3d{0, 0, 1});
  const std::vector<Vec3d> along_x(5, Vec3d{1, 0, 0});
  std::vector<Vec3d> after = fan.positions;
  for (Vec3d& p : after) p = turned(p, {0, 0, 1}, 0.4);
  for (const Vec3d& t : transport_tangents(fan, after, along_x, up)) {
    EXPECT_NEAR(norm(t - Vec3d{std::cos(0.4), std::sin(0.4), 0}), 0, 1e-15 * 10);
  }
  // A shear takes x to x and y to y + x: the tangent, as the map of the surface says, and not the mean turn.
  after = fan.positions;
  for (Vec3d& p : after) p.y += p.x;
  for (const Vec3d& t : transport_tangents(fan, after, along_x, up)) {
    EXPECT_NEAR(norm(t - normalized(Vec3d{1, 1, 0})), 0, 1e-15 * 10);
  }
}

TEST(TransportTangents, KeepTheirBitsAwayFromWhatMoved) {
  const Mesh torus = quad_torus(20, 12);
  const std::vector<Vec3d> normals = vertex_normals(torus);
  const std::vector<Vec3d> tangents = random_normals(torus.vertex_count());
  EXPECT_EQ(transport_tangents(torus, torus.positions, tangents, normals), tangents);
  std::vector<Vec3d> after = torus.positions;
  after[0] += Vec3d{0.1, 0.05, 0.1};
  const std::vector<Vec3d> moved = transport_tangents(torus, after, tangents, vertex_normals(torus, after));
  std::size_t changed = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) changed += moved[i] == tangents[i] ? 0 : 1;
  EXPECT_EQ(changed, 9u);  // the vertex and those of its four quads
}

TEST(TransportTangents, WithoutAnAreaAroundStayAcrossTheNormal) {
  const Mesh line = make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
  std::vector<Vec3d> after = line.positions;
  after[1].x = 1.5;
  const std::vector<Vec3d> slanted(3, normalized(Vec3d{1, 0, 1}));
  for (const Vec3d& t : transport_tangents(line, after, slanted, std::vector<Vec3d>(3, Vec3d{0, 0, 1}))) {
    EXPECT_NEAR(norm(t - Vec3d{1, 0, 0}), 0, 1e-15);
  }
}

TEST(VertexNormals, OfSomeHaveTheSameBits) {
  const Mesh torus = quad_torus(20, 10);
  const std::vector<Vec3d> all = vertex_normals(torus);
  std::vector<bool> needed(all.size(), false);
  for (std::size_t i = 0; i < all.size(); i += 7) needed[i] = true;
  const std::vector<Vec3d> some = vertex_normals(torus, torus.positions, needed);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(some[i], needed[i] ? all[i] : Vec3d{}) << i;
}

}  // namespace
}  // namespace knead::normals_test
