// The half-edge mesh after random splits, flips and collapses.
#include "remesh/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "knead/mesh.h"
#include "mesh/manifold_check.h"
#include "remesh/facets.h"
#include "remesh/patch.h"

namespace knead::detail::surface_test {
namespace {

Surface surface_of(const Mesh& mesh) {
  Surface s;
  s.before = mesh.positions;
  s.after = mesh.positions;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (const std::uint32_t v : mesh.face(f)) s.corner.push_back(v);
    s.face_source.push_back(static_cast<std::uint32_t>(f));
  }
  s.corner_values.stride = 1;  // the vertex that a corner is at, to be found there after every change
  s.vertex_values.stride = 0;
  for (const std::uint32_t v : s.corner) s.corner_values.numbers.push_back(v);
  connect(s);
  return s;
}

Mesh mesh_of(const Surface& s) {
  Mesh mesh;
  std::vector<std::uint32_t> number(s.vertex_count(), kNone);
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f)) continue;
    std::vector<std::uint32_t> face;
    for (const std::uint32_t v : s.triangle(f)) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(s.after[v]);
      }
      face.push_back(number[v]);
    }
    mesh.add_face(face);
  }
  return mesh;
}

// Checks the links between half-edges, edges and vertices.
void expect_sound(const Surface& s) {
  std::vector<std::set<std::uint32_t>> uses(s.halfedge.size());
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if (s.corner[h] == kNone) continue;
    ASSERT_NE(s.edge[h], kNone);
    uses[s.edge[h]].insert(h);
    const std::uint32_t o = s.opposite[h];
    if (o == kNone) continue;
    ASSERT_EQ(s.opposite[o], h);
    ASSERT_EQ(s.origin(h), s.target(o));
    ASSERT_EQ(s.edge[h], s.edge[o]);
  }
  for (std::uint32_t e = 0; e < s.halfedge.size(); ++e) {
    if (s.halfedge[e] == kNone) {
      ASSERT_TRUE(uses[e].empty()) << "edge " << e;
    } else {
      ASSERT_EQ(uses[e].count(s.halfedge[e]), 1U) << "edge " << e;
    }
  }
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (s.has(v, kRemoved)) continue;
    ASSERT_EQ(s.origin(s.outgoing[v]), v);
  }
}

TEST(Surface, RandomChangesKeepTheManifoldAndItsEulerCharacteristic) {
  const Mesh torus = make_shape(ShapeKind::torus, 300);
  const std::int64_t euler = test::euler_characteristic(torus);
  Surface s = surface_of(torus);
  std::mt19937_64 random(7);
  std::size_t collapsed = 0;
  std::size_t flipped = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto e = static_cast<std::uint32_t>(random() % s.halfedge.size());
    const std::uint32_t h = s.halfedge[e];
    if (h == kNone) continue;
    const std::uint64_t kind = random() % 3;
    if (kind == 0) {
      const Vec3d middle = (s.after[s.origin(h)] + s.after[s.target(h)]) * 0.5;
      split(s, h, middle, middle);
    } else if (kind == 1 && can_collapse(s, h)) {
      collapse(s, h, s.after[s.target(h)], 0);
      ++collapsed;
    } else if (kind == 2) {
      std::set<std::uint32_t> ring;
      s.for_each_outgoing(s.apex(h), [&](std::uint32_t k) { ring.insert(s.target(k)); });
      if (ring.count(s.apex(s.opposite[h])) > 0 || s.apex(h) == s.apex(s.opposite[h])) continue;
      // No vertex may be left with two faces.
      std::size_t degree_a = 0;
      std::size_t degree_b = 0;
      s.for_each_outgoing(s.origin(h), [&](std::uint32_t) { ++degree_a; });
      s.for_each_outgoing(s.target(h), [&](std::uint32_t) { ++degree_b; });
      if (std::min(degree_a, degree_b) < 4) continue;
      flip(s, h);
      ++flipped;
    }
  }
  EXPECT_GT(collapsed, 300U);
  EXPECT_GT(flipped, 300U);
  expect_sound(s);
  const Mesh mesh = mesh_of(s);
  EXPECT_EQ(test::closed_manifold_components(mesh), 1);
  EXPECT_EQ(test::euler_characteristic(mesh), euler);
}

TEST(Surface, CornerValuesStayWithTheirVerticesInFlips) {
  Surface s = surface_of(make_shape(ShapeKind::sphere, 100));
  for (std::uint32_t h = 0; h < s.corner.size(); h += 5) flip(s, h);
  for (std::uint32_t c = 0; c < s.corner.size(); ++c) EXPECT_EQ(s.corner_values.numbers[c], s.corner[c]);
}

TEST(Surface, SplitsGiveTheMeanAtTheNewCorners) {
  Surface s = surface_of(make_shape(ShapeKind::sphere, 50));
  const std::uint32_t a = s.origin(0);
  const std::uint32_t b = s.target(0);
  const std::uint32_t m = split(s, 0, s.before[a], s.after[a]);
  std::size_t corners = 0;
  for (std::uint32_t c = 0; c < s.corner.size(); ++c) {
    const double expected = s.corner[c] == m ? 0.5 * (a + b) : s.corner[c];
    EXPECT_EQ(s.corner_values.numbers[c], expected);
    corners += s.corner[c] == m ? 1 : 0;
  }
  EXPECT_EQ(corners, 4U);
}

TEST(Surface, ThinPlacesAreNotPinchedByACollapse) {
  // Three vertices form a waist without a face; on each side of it are four more.
  Mesh mesh;
  mesh.positions = {{0, 0, 2}, {0, 0, -2}, {1, 0, 0}, {-0.5, 0.9, 0}, {-0.5, -0.9, 0}};
  for (std::uint32_t i = 0; i < 3; ++i) {
    const std::uint32_t a = 2 + i;
    const std::uint32_t b = 2 + (i + 1) % 3;
    mesh.add_face(std::array{0U, a, b});
    mesh.add_face(std::array{1U, b, a});
  }
  Surface s = surface_of(mesh);
  for (int i = 0; i < 12; ++i) {  // so that every vertex has more than three faces
    const std::uint32_t h = s.corner[0] == 0 ? 0U : static_cast<std::uint32_t>(3 * i);
    const Vec3d middle = (s.after[s.origin(h)] + s.after[s.target(h)]) * 0.5;
    split(s, h, middle, middle);
  }
  std::size_t refused = 0;
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    Surface copy = s;
    if (!can_collapse(copy, h)) {
      ++refused;
      continue;
    }
    collapse(copy, h, copy.after[copy.target(h)], 0);
    expect_sound(copy);
    EXPECT_EQ(test::closed_manifold_components(mesh_of(copy)), 1);
  }
  EXPECT_GT(refused, 5U);
  EXPECT_LT(refused, s.corner.size());
}

TEST(Surface, EdgesOfThreeFacesAndOnesThatDisagreeAreSplitAtOneVertex) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  const std::vector<std::array<std::uint32_t, 3>> faces{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  for (const auto& face : faces) mesh.add_face(face);
  Surface s = surface_of(mesh);
  EXPECT_TRUE(s.edge_has(0, kBoundary));
  EXPECT_TRUE(s.has_copies(s.edge[0]));
  EXPECT_TRUE(s.has(0, kImmovable));
  EXPECT_TRUE(s.has(1, kImmovable));
  EXPECT_FALSE(s.has(2, kImmovable));
  EXPECT_FALSE(s.has_copies(s.edge[1]));
  // Twice: each half is again an edge of three faces.
  const std::uint32_t m = split(s, 3, {0.5, 0, 0}, {0.5, 0, 0});
  EXPECT_EQ(s.face_count(), 6u);
  EXPECT_TRUE(s.has(m, kImmovable));
  const std::uint32_t h = s.halfedge[s.edge[0]];
  const std::uint32_t n = split(s, h, {0.25, 0, 0}, {0.25, 0, 0});
  EXPECT_EQ(s.face_count(), 9u);
  Mesh result;
  result.positions = s.after;
  for (std::size_t f = 0; f < s.face_count(); ++f) result.add_face(s.triangle(f));
  const Measures measures = measure(result);
  EXPECT_EQ(measures.nonmanifold_edges, 3u);
  EXPECT_EQ(measures.boundary_edges, 6u);
  EXPECT_NE(m, n);
}

// A ball that was pushed about, with thin triangles, a hole and a pinched vertex.
Mesh rough_ball(double roughness) {
  std::mt19937 random(7);
  const Mesh ball = make_shape(ShapeKind::sphere, 6000);
  Mesh mesh;
  mesh.positions = ball.positions;
  for (Vec3d& p : mesh.positions) p *= 1 + roughness * (static_cast<double>(random() % 1000) / 1000 - 0.5);
  for (std::size_t v = 0; v < 300; ++v) {  // onto a neighbour, or nearly
    const auto face = ball.face(random() % ball.face_count());
    mesh.positions[face[0]] = mesh.positions[face[1]] + (mesh.positions[face[2]] - mesh.positions[face[1]]) * 1e-3;
    if (v % 3 == 0) mesh.positions[face[0]] = mesh.positions[face[1]];
  }
  for (std::size_t f = 0; f < ball.face_count(); ++f) {
    std::vector<std::uint32_t> face(ball.face(f).begin(), ball.face(f).end());
    if (f % 500 == 7) continue;
    if (f % 700 == 3) face[0] = 11;
    if (f % 900 == 5) std::swap(face[0], face[1]);
    mesh.add_face(face);
  }
  return mesh;
}

TEST(Surface, CreasesAreThoseOfAllTrianglesAtOnce) {
  std::size_t creases = 0;
  for (const double roughness : {0.0, 0.002, 0.01, 0.05}) {
    const Mesh mesh = rough_ball(roughness);
    Surface all;
    all.before = mesh.positions;
    all.after = mesh.positions;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      const auto t = mesh.face(f);
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      all.corner.insert(all.corner.end(), t.begin(), t.end());
      all.face_source.push_back(0);
    }
    connect(all);
    for (const double angle : {0.05, 1.0, 20.0, 40.0, 90.0, 179.0, 300.0}) {
      const std::vector<MeshEdge> found = find_creases(mesh, angle);
      EXPECT_EQ(found, find_crease_edges(all, angle, plane_tolerance(mesh.positions))) << roughness << " " << angle;
      creases += found.size();
    }
  }
  EXPECT_GT(creases, 500u);
}

TEST(Surface, LengthsForEdgesComeFromAllEdges) {
  const Mesh mesh = rough_ball(0.05);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto t = mesh.face(f);
    for (std::size_t i = 0; i < 3; ++i) {
      if (t[i] != t[(i + 1) % 3]) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    }
  }
  std::vector<double> lengths;
  lengths.reserve(edges.size());
  for (const auto& [a, b] : edges) lengths.push_back(norm(mesh.positions[b] - mesh.positions[a]));
  std::sort(lengths.begin(), lengths.end());
  double mean = 0;
  for (const double length : lengths) mean += length / static_cast<double>(lengths.size());
  for (const int threads : {1, 2, 4}) {
    const RemeshTargets targets = resolve_on({}, mesh, threads);
    EXPECT_EQ(targets.max_edge, 2 * lengths[lengths.size() - 1 - lengths.size() / 20]);
    EXPECT_NEAR(targets.min_edge, mean / 4, 1e-12 * mean);
  }
}

}  // namespace
}  // namespace knead::detail::surface_test
