// Counts, volumes and areas of meshes, against values by hand and by brute force.
#include "knead/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <set>

#include "knead/io.h"
#include "mesh/edges.h"
#include "mesh/test_shapes.h"
#include "support/test_meshes.h"

namespace knead::measures_test {
namespace {

struct Known {
  const char* file;
  std::size_t vertices, faces, boundary_loops, nonmanifold_edges, nonmanifold_vertices, misoriented_edges, components;
  std::int64_t euler;
  std::optional<double> volume;  // of closed meshes
  double diagonal;

  friend std::ostream& operator<<(std::ostream& out, const Known& known) { return out << known.file; }
};

// The figures published with the meshes.
const Known kKnown[] = {
    {"armadillo_173k_constructed.ply", 172966, 345928, 0, 0, 0, 0, 1, 2, 0.0685591, 1.511},
    {"armadillo_43k.ply", 43243, 86482, 0, 0, 0, 0, 1, 2, 0.0686187, 1.512},
    {"bar_6k.ply", 6146, 12288, 0, 0, 0, 0, 1, 2, 22.9527, 6.397},
    {"bunny_35k.ply", 34835, 69666, 0, 0, 0, 0, 1, 2, 0.000754809, 0.2502},
    {"bust_demosthenes_8k_open.ply", 8394, 16719, 1, 0, 0, 0, 1, 1, {}, 3.561},
    {"bust_maxplanck_5k.ply", 5272, 10540, 0, 0, 0, 0, 1, 2, 5.72135e+06, 461},
    {"bust_nefertiti_35k.ply", 35002, 70000, 0, 0, 0, 0, 1, 2, 1.15533e+07, 658.1},
    {"camel_22k_nonmanifold.ply", 21887, 43814, 2, 26, 38, 0, 1, 3, {}, 1.396},
    {"camel_35k.ply", 34546, 69092, 0, 0, 0, 0, 1, 0, 0.132863, 2.029},
    {"dragon_100k_stanford_res2.ply", 100250, 202520, 0, 2534, 3723, 0, 7, 1520, 0.000477919, 0.2666},
    {"dragon_438k_constructed.ply", 437645, 875290, 0, 0, 0, 0, 1, 0, 1.10051, 3.522},
    {"dragon_50k.ply", 50000, 100000, 0, 0, 0, 0, 1, 0, 1.10236, 3.525},
    {"fandisk_6k.ply", 6475, 12946, 0, 0, 0, 0, 1, 2, 20.2434, 7.616},
    {"hand_50k.ply", 49858, 99712, 0, 0, 0, 0, 1, 2, 21.3699, 8.685},
    {"hand_53k_open.ply", 53054, 105860, 1, 0, 0, 0, 1, 1, {}, 1.253},
    {"hemisphere_2k_open.ply", 1861, 3600, 1, 0, 0, 0, 1, 1, {}, 2.956},
    {"moebius_open.ply", 280, 448, 1, 0, 0, 4, 1, 0, {}, 55.87},
    {"mountain_26k_open.ply", 25600, 50562, 1, 0, 0, 0, 1, 1, {}, 49.95},
    {"scorpion_6k.ply", 6315, 12626, 0, 0, 0, 0, 1, 2, 12.1785, 12.08},
    {"sphere_16k.ply", 16070, 32136, 0, 0, 0, 0, 1, 2, 4.18734, 3.464},
    {"sphere_642.ply", 642, 1280, 0, 0, 0, 0, 1, 2, 4.15268, 3.464},
    {"spider_762_open.ply", 762, 1368, 8, 0, 0, 10, 19, 30, {}, 257.7},
    {"torus_2k.ply", 2304, 4608, 0, 0, 0, 0, 1, 0, 1.21878, 3.571},
    {"wingnut_3k.ply", 3047, 6090, 0, 0, 0, 0, 1, 2, 22.0966, 8.903},
};

class KnownMesh : public testing::TestWithParam<Known> {};

TEST_P(KnownMesh, MeasuresAsPublished) {
  const Known& known = GetParam();
  KNEAD_NEEDS_TEST_MESH(known.file);
  const Measures m = measure(read_shape(test_mesh(known.file)).mesh);
  EXPECT_EQ(m.vertices, known.vertices);
  EXPECT_EQ(m.faces, known.faces);
  EXPECT_EQ(m.triangles, known.faces);
  EXPECT_EQ(m.closed(), known.volume.has_value());
  EXPECT_EQ(m.manifold(), known.nonmanifold_edges == 0);
  EXPECT_EQ(m.boundary_loops, known.boundary_loops);
  EXPECT_EQ(m.nonmanifold_edges, known.nonmanifold_edges);
  EXPECT_EQ(m.nonmanifold_vertices, known.nonmanifold_vertices);
  EXPECT_EQ(m.misoriented_edges, known.misoriented_edges);
  EXPECT_EQ(m.components, known.components);
  EXPECT_EQ(m.euler, known.euler);
  // Published with six and four digits.
  if (known.volume) {
    EXPECT_NEAR(m.volume, *known.volume, 5.1e-6 * std::abs(*known.volume));
  }
  EXPECT_NEAR(m.box.diagonal(), known.diagonal, 5.1e-4 * known.diagonal);
}

std::string mesh_name(const testing::TestParamInfo<Known>& known) {
  const std::string file = known.param.file;
  return file.substr(0, file.find('.'));
}

INSTANTIATE_TEST_SUITE_P(Published, KnownMesh, testing::ValuesIn(kKnown), mesh_name);

TEST(Measures, DegenerateTrianglesAndUnusedVerticesAsPublished) {
  KNEAD_NEEDS_TEST_MESH("spider_762_open.ply");
  EXPECT_EQ(measure(read_shape(test_mesh("spider_762_open.ply")).mesh).degenerate_triangles, 56u);
  EXPECT_EQ(measure(read_shape(test_mesh("dragon_100k_stanford_res2.ply")).mesh).unused_vertices, 43u);
}

TEST(Measures, CubeAndTorus) {
  const Measures cube = measure(unit_cube());
  EXPECT_EQ(cube.edges, 12u);
  EXPECT_EQ(cube.triangles, 12u);
  EXPECT_EQ(cube.euler, 2);
  EXPECT_DOUBLE_EQ(cube.volume, 1);
  EXPECT_DOUBLE_EQ(cube.area, 6);
  EXPECT_TRUE(cube.closed() && cube.manifold() && cube.oriented());
  EXPECT_TRUE(describe_defects(cube).empty());
  const Measures torus = measure(quad_torus(200, 100));
  EXPECT_EQ(torus.euler, 0);
  EXPECT_EQ(torus.components, 1u);
  EXPECT_NEAR(torus.volume, 2 * std::numbers::pi * std::numbers::pi * 0.16, 2e-3 * torus.volume);  // 2 pi^2 R r^2
}

TEST(Measures, VolumeAndAreaDoNotDependOnPlaceAndTurnWithOrientation) {
  const Mesh torus = quad_torus(30, 20);
  const Measures m = measure(torus);
  Mesh moved = torus;
  for (Vec3d& p : moved.positions) p += Vec3d{1000, -2000, 500};
  EXPECT_NEAR(measure(moved).volume, m.volume, 1e-11 * m.volume);  // 2000 * 2^-53 in each coordinate
  Mesh turned = torus;
  for (std::size_t f = 0; f < turned.face_count(); ++f) {
    std::reverse(turned.corner_vertex.begin() + turned.face_begin[f],
                 turned.corner_vertex.begin() + turned.face_begin[f + 1]);
  }
  EXPECT_NEAR(measure(turned).volume, -m.volume, 1e-13 * m.volume);
  EXPECT_TRUE(measure(turned).oriented());
  EXPECT_EQ(measure_volume_and_area(torus, torus.positions).volume, m.volume);
  EXPECT_EQ(measure_volume_and_area(torus, torus.positions).area, m.area);
}

TEST(Measures, CountsDoNotDependOnTheOrderOfFaces) {
  const Mesh torus = quad_torus(12, 9);
  std::vector<std::size_t> order(torus.face_count() - 5);  // with a hole
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  Mesh shuffled;
  shuffled.positions = torus.positions;
  for (const std::size_t f : order) shuffled.add_face(torus.face(f));
  const Measures m = measure(shuffled);
  EXPECT_EQ(m.boundary_loops, 1u);
  EXPECT_EQ(m.boundary_edges, 12u);
  EXPECT_EQ(m.euler, -1);
  EXPECT_TRUE(m.manifold() && m.oriented() && !m.closed());
}

TEST(Measures, BowTiesAndLooseParts) {
  const Mesh bow_tie =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {9, 9, 9}}, {{0, 1, 2}, {0, 3, 4}});
  const Measures m = measure(bow_tie);
  EXPECT_EQ(m.nonmanifold_vertices, 1u);
  EXPECT_EQ(m.components, 1u);
  EXPECT_EQ(m.boundary_loops, 2u);
  EXPECT_EQ(m.unused_vertices, 1u);
  EXPECT_EQ(m.euler, 1);
  const Mesh fan =
      make_mesh({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
  EXPECT_EQ(measure(fan).nonmanifold_edges, 1u);
  EXPECT_FALSE(measure(fan).manifold());
}

// Few vertices and many faces, so that edges are used by all numbers of faces, in both directions.
TEST(Measures, ClosedAndOrientedWithoutTheRest) {
  std::mt19937 random(1);
  std::size_t sound = 0;
  for (int round = 0; round < 20'000; ++round) {
    Mesh mesh;
    mesh.positions.resize(4 + random() % 3);
    const std::size_t faces = random() % 9;
    for (std::size_t f = 0; f < faces; ++f) {
      std::vector<std::uint32_t> face(3 + random() % 2);
      for (std::uint32_t& v : face) v = static_cast<std::uint32_t>(random() % mesh.positions.size());
      mesh.add_face(face);
    }
    const Measures measures = measure(mesh);
    EXPECT_EQ(is_closed_and_oriented(mesh), measures.closed() && measures.oriented()) << round;
    sound += is_closed_and_oriented(mesh) ? 1 : 0;
  }
  EXPECT_GT(sound, 20u);
  EXPECT_TRUE(is_closed_and_oriented(quad_torus(20, 10)));
}

// A torus of triangles and quads in no order, of which some corners went astray: with holes, pinched vertices, edges of
// many faces, and faces that repeat a vertex.
Mesh damaged_torus(std::mt19937& random, unsigned rate) {
  const Mesh torus = quad_torus(120, 80);  // several parts
  Mesh mesh;
  mesh.positions = torus.positions;
  std::vector<std::size_t> order(torus.face_count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), random);
  for (const std::size_t f : order) {
    std::vector<std::uint32_t> face(torus.face(f).begin(), torus.face(f).end());
    for (std::uint32_t& v : face) {
      if (random() % 1000 < rate) v = static_cast<std::uint32_t>(random() % mesh.positions.size());
      if (random() % 1000 < rate) v = face[0];
    }
    if (random() % 1000 < rate) std::reverse(face.begin(), face.end());
    if (random() % 200 < rate) face.resize(random() % 5);
    mesh.add_face(face);
  }
  return mesh;
}

using Edges = std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<EdgeUse>>;

Edges edges_of(const Mesh& mesh) {
  Edges edges;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
      const std::uint32_t next = c + 1 < mesh.face_begin[f + 1] ? c + 1 : mesh.face_begin[f];
      const auto [low, high] = std::minmax(mesh.corner_vertex[c], mesh.corner_vertex[next]);
      if (low < high) edges[{low, high}].push_back({low, high, c, next, mesh.corner_vertex[c] == low});
    }
  }
  return edges;
}

bool same(const EdgeUse& a, const EdgeUse& b) {
  return a.low == b.low && a.high == b.high && a.corner == b.corner && a.next_corner == b.next_corner &&
         a.upward == b.upward;
}

TEST(Edges, ComeInTheirOrderWithAllUses) {
  std::mt19937 random(2);
  for (const unsigned rate : {0U, 1U, 20U, 200U}) {
    const Mesh mesh = damaged_torus(random, rate);
    const Edges edges = edges_of(mesh);
    auto expected = edges.begin();
    for_each_edge(mesh, [&](std::span<const EdgeUse> uses) {
      ASSERT_NE(expected, edges.end());
      EXPECT_TRUE(std::equal(uses.begin(), uses.end(), expected->second.begin(), expected->second.end(), same));
      ++expected;
    });
    EXPECT_EQ(expected, edges.end());
  }
}

// The slow way: one set of all corners for the fans, and one of all fans for the boundary loops.
TEST(Measures, CountsOfEdgesFansAndLoopsAreThoseOfAllCornersAtOnce) {
  std::mt19937 random(3);
  std::size_t loops = 0;
  for (const unsigned rate : {0U, 1U, 5U, 20U, 200U}) {
    const Mesh mesh = damaged_torus(random, rate);
    const Edges edges = edges_of(mesh);
    DisjointSets fans(mesh.corner_vertex.size());
    std::size_t boundary = 0;
    std::size_t many = 0;
    for (const auto& [ends, uses] : edges) {
      boundary += uses.size() == 1 ? 1 : 0;
      many += uses.size() > 2 ? 1 : 0;
      if (uses.size() != 2) continue;
      const bool same_way = uses[0].upward == uses[1].upward;
      fans.join(uses[0].corner, same_way ? uses[1].corner : uses[1].next_corner);
      fans.join(uses[0].next_corner, same_way ? uses[1].next_corner : uses[1].corner);
    }
    DisjointSets looped = fans;
    std::set<std::uint32_t> found;
    for (const auto& [ends, uses] : edges) {
      if (uses.size() == 1) looped.join(uses[0].corner, uses[0].next_corner);
    }
    for (const auto& [ends, uses] : edges) {
      if (uses.size() == 1) found.insert(looped.find(uses[0].corner));
    }
    std::vector<std::set<std::uint32_t>> fans_of(mesh.vertex_count());
    for (std::uint32_t c = 0; c < mesh.corner_vertex.size(); ++c) fans_of[mesh.corner_vertex[c]].insert(fans.find(c));
    const Measures m = measure(mesh);
    EXPECT_EQ(m.edges, edges.size());
    EXPECT_EQ(m.boundary_edges, boundary);
    EXPECT_EQ(m.nonmanifold_edges, many);
    EXPECT_EQ(m.boundary_loops, found.size());
    EXPECT_EQ(m.unused_vertices,
              std::count_if(fans_of.begin(), fans_of.end(), [](const auto& f) { return f.empty(); }));
    EXPECT_EQ(m.nonmanifold_vertices,
              std::count_if(fans_of.begin(), fans_of.end(), [](const auto& f) { return f.size() > 1; }));
    loops += found.size();
  }
  EXPECT_GT(loops, 100u);
}

TEST(Measures, NothingAtAll) {
  const Measures none = measure(Mesh{});
  EXPECT_EQ(none.euler, 0);
  EXPECT_EQ(none.volume, 0);
  EXPECT_FALSE(none.closed());
  const Measures points = measure(make_mesh({{1, 2, 3}, {4, 5, 6}}, {}));
  EXPECT_EQ(points.components, 0u);
  EXPECT_EQ(points.unused_vertices, 2u);
}

// The faces of a shape with other positions: everything but the topology changes.
TEST(Measures, FromTheSameFacesAreTheSame) {
  for (const DirtyShape& shape : dirty_shapes()) {
    const Measures first = measure(shape.mesh);
    Mesh moved = shape.mesh;
    for (Vec3d& p : moved.positions) p = {p.x + 0.3 * p.y * p.y, 2 * p.y, p.z * p.x};
    const Measures all = measure(moved);
    const Measures quick = measure(moved, first);
    EXPECT_EQ(quick.triangles, all.triangles) << shape.name;
    EXPECT_EQ(quick.degenerate_triangles, all.degenerate_triangles) << shape.name;
    EXPECT_EQ(quick.smallest_angle_deg, all.smallest_angle_deg) << shape.name;
    EXPECT_EQ(quick.volume, all.volume) << shape.name;
    EXPECT_EQ(quick.area, all.area) << shape.name;
    EXPECT_EQ(quick.euler, all.euler) << shape.name;
    EXPECT_EQ(quick.closed(), all.closed()) << shape.name;
    EXPECT_EQ(quick.oriented(), all.oriented()) << shape.name;
    EXPECT_EQ(quick.box.diagonal(), all.box.diagonal()) << shape.name;
  }
}

// Right triangles of known angles, of every size, with the corners in every order.
TEST(SmallestAngle, IsThatOfTheTriangle) {
  for (const double degrees : {1e-6, 0.5, 5.0, 20.0, 30.0, 44.9}) {
    for (const double size : {1e-30, 1.0, 1e30}) {
      const Vec3d far{size, 0, 0};
      const Vec3d high{size, size * std::tan(degrees * std::numbers::pi / 180), 0};
      for (const Mesh& mesh : {make_mesh({{}, far, high}, {{0, 1, 2}}), make_mesh({far, high, {}}, {{0, 1, 2}}),
                               make_mesh({high, {}, far}, {{0, 1, 2}})}) {
        const std::optional<double> angle = measure(mesh).smallest_angle_deg;
        ASSERT_TRUE(angle.has_value());
        EXPECT_NEAR(*angle, degrees, 1e-14 * degrees);  // some tens of roundings, no cancellation
      }
    }
  }
}

TEST(SmallestAngle, IsThatOfTheWorstTriangleThatHasAnArea) {
  EXPECT_NEAR(*measure(unit_cube()).smallest_angle_deg, 45, 1e-12);
  const Mesh mixed =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0.5, 0.8, 0}, {2, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 3, 4}});
  EXPECT_NEAR(*measure(mixed).smallest_angle_deg, 45, 1e-12);
  EXPECT_EQ(measure(make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}})).smallest_angle_deg, std::nullopt);
  EXPECT_EQ(measure(Mesh{}).smallest_angle_deg, std::nullopt);
}

}  // namespace
}  // namespace knead::measures_test
