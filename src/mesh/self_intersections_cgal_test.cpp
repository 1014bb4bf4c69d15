// Compares the pairs with those of CGAL, on scans and on difficult surfaces.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "knead/io.h"
#include "knead/mesh.h"
#include "mesh/test_shapes.h"
#include "support/test_meshes.h"

namespace knead::self_intersections_cgal_test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Pair = std::array<std::uint32_t, 2>;
using Pairs = std::vector<Pair>;

Pair ordered(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

Point to_cgal(const Vec3d& p) { return {p.x, p.y, p.z}; }

// Calls CGAL's function; returns nothing if CGAL's mesh cannot hold the triangles.
std::optional<Pairs> of_cgal_mesh(std::span<const Triangle> triangles, std::span<const Vec3d> positions) {
  SurfaceMesh mesh;
  for (const Vec3d& p : positions) mesh.add_vertex(to_cgal(p));
  for (const Triangle& t : triangles) {
    const auto face = mesh.add_face(SurfaceMesh::Vertex_index(t[0]), SurfaceMesh::Vertex_index(t[1]),
                                    SurfaceMesh::Vertex_index(t[2]));
    if (face == SurfaceMesh::null_face()) return {};
  }
  std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> found;
  CGAL::Polygon_mesh_processing::self_intersections<CGAL::Sequential_tag>(mesh, std::back_inserter(found));
  Pairs pairs;
  for (const auto& [f, g] : found) pairs.push_back(ordered(f.idx(), g.idx()));
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// Applies the rule of that function to two triangles, with CGAL's predicates. It needs no CGAL mesh.
class CgalRule {
 public:
  CgalRule(std::span<const Triangle> triangles, std::span<const Vec3d> positions)
      : triangles_(triangles), positions_(positions) {}

  bool collinear(std::uint32_t t) const {
    return CGAL::collinear(point(triangles_[t][0]), point(triangles_[t][1]), point(triangles_[t][2]));
  }

  CGAL::Bbox_3 box(std::uint32_t t) const { return triangle(triangles_[t]).bbox(); }

  bool operator()(std::uint32_t i, std::uint32_t j) const {
    const Triangle t = shared_first(triangles_[i], triangles_[j]);
    const Triangle u = shared_first(triangles_[j], triangles_[i]);
    const auto shared = std::count_if(t.begin(), t.end(), [&](std::uint32_t v) { return contains(u, v); });
    if (shared == 0) return CGAL::do_intersect(triangle(t), triangle(u));
    if (shared == 1) {
      return CGAL::do_intersect(triangle(t), Kernel::Segment_3(point(u[1]), point(u[2]))) ||
             CGAL::do_intersect(triangle(u), Kernel::Segment_3(point(t[1]), point(t[2])));
    }
    if (shared == 3) return true;  // for CGAL a neighbour in the same plane, on the same side of the common edge
    return CGAL::coplanar(point(t[0]), point(t[1]), point(t[2]), point(u[2])) &&
           CGAL::coplanar_orientation(point(t[0]), point(t[1]), point(t[2]), point(u[2])) == CGAL::POSITIVE;
  }

 private:
  static bool contains(const Triangle& t, std::uint32_t v) { return std::find(t.begin(), t.end(), v) != t.end(); }

  static Triangle shared_first(Triangle t, const Triangle& other) {
    std::stable_partition(t.begin(), t.end(), [&](std::uint32_t v) { return contains(other, v); });
    return t;
  }

  Point point(std::uint32_t v) const { return to_cgal(positions_[v]); }
  Kernel::Triangle_3 triangle(const Triangle& t) const { return {point(t[0]), point(t[1]), point(t[2])}; }

  std::span<const Triangle> triangles_;
  std::span<const Vec3d> positions_;
};

Pairs by_cgal_rule(std::span<const Triangle> triangles, std::span<const Vec3d> positions) {
  using CgalBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
  const CgalRule rule(triangles, positions);
  Pairs pairs;
  std::vector<CgalBox> boxes;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (rule.collinear(t)) {
      pairs.push_back({t, t});
    } else {
      boxes.emplace_back(rule.box(t), t);
    }
  }
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const CgalBox& a, const CgalBox& b) {
    if (rule(a.info(), b.info())) pairs.push_back(ordered(a.info(), b.info()));
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// Without triangles of the same three corners, which CGAL 5.5 finds and CGAL 6.0 passes over.
Pairs without_twins(Pairs pairs, std::span<const Triangle> triangles) {
  std::erase_if(pairs, [&](const Pair& pair) {
    const Triangle& t = triangles[pair[0]];
    return pair[0] != pair[1] && std::is_permutation(t.begin(), t.end(), triangles[pair[1]].begin());
  });
  return pairs;
}

void expect_the_same(const std::string& name, const Mesh& mesh) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  const Pairs ours = self_intersections(triangles, mesh.positions).pairs;
  EXPECT_EQ(ours, by_cgal_rule(triangles, mesh.positions)) << name;
  const std::optional<Pairs> theirs = of_cgal_mesh(triangles, mesh.positions);
  if (theirs) {
    EXPECT_EQ(without_twins(ours, triangles), without_twins(*theirs, triangles)) << name;
  }
  std::printf("%s: %zu pairs, %s\n", name.c_str(), ours.size(), theirs ? "compared with both" : "by the rule alone");
}

class CgalMesh : public testing::TestWithParam<const char*> {};

TEST_P(CgalMesh, HasTheSamePairs) {
  KNEAD_NEEDS_TEST_MESH(GetParam());
  expect_the_same(GetParam(), read_shape(test_mesh(GetParam())).mesh);
}

INSTANTIATE_TEST_SUITE_P(Scans, CgalMesh,
                         testing::Values("armadillo_43k.ply", "bar_6k.ply", "bunny_35k.ply",
                                         "bust_demosthenes_8k_open.ply", "bust_maxplanck_5k.ply",
                                         "camel_22k_nonmanifold.ply", "dragon_100k_stanford_res2.ply", "fandisk_6k.ply",
                                         "hand_50k.ply", "hand_53k_open.ply", "moebius_open.ply",
                                         "mountain_26k_open.ply", "scorpion_6k.ply", "spider_762_open.ply",
                                         "wingnut_3k.ply", "originals/pirate_quads_normals_uv.obj"),
                         [](const auto& test) {
                           std::string name = test.param;
                           name.resize(name.find('.'));
                           return name.substr(name.find('/') + 1);
                         });

TEST(Cgal, HasTheSamePairsOfDirtyShapes) {
  for (const DirtyShape& shape : dirty_shapes()) {
    if (shape.name == "a corner just above a triangle") continue;  // no double is too small for CGAL
    expect_the_same(shape.name, shape.mesh);
  }
}

// Corners on a coarse grid: produces every case of touching, overlapping and degenerate triangles.
TEST(Cgal, HasTheSamePairsOfTrianglesOnAGrid) {
  std::mt19937 random(1);
  const auto pick = [&](std::uint32_t count) {
    return std::uniform_int_distribution<std::uint32_t>(0, count - 1)(random);
  };
  for (int round = 0; round < 30; ++round) {
    Mesh mesh;
    const std::uint32_t height = round % 3 == 0 ? 1 : 4;   // in a plane, or in space
    const double unit = round % 2 == 0 ? 1 : 0.1;          // 0.1 is not exact: corners are nearly on lines and planes
    const std::uint32_t vertices = round < 15 ? 60 : 450;  // shared at random, or each triangle's own
    for (std::uint32_t v = 0; v < vertices; ++v) {
      mesh.positions.push_back(Vec3d{1.0 * pick(5), 1.0 * pick(5), 1.0 * pick(height)} * unit);
    }
    for (std::uint32_t t = 0; t < 150; ++t) {
      mesh.add_face(round < 15 ? std::array{pick(60), pick(60), pick(60)} : std::array{3 * t, 3 * t + 1, 3 * t + 2});
    }
    expect_the_same("triangles on a grid", mesh);
  }
}

}  // namespace
}  // namespace knead::self_intersections_cgal_test
