// Small meshes for the tests of this module.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "knead/mesh.h"

namespace knead {

inline Mesh make_mesh(std::initializer_list<Vec3d> positions,
                      std::initializer_list<std::initializer_list<std::uint32_t>> faces) {
  Mesh mesh;
  mesh.positions = positions;
  for (const auto& face : faces) mesh.add_face({face.begin(), face.size()});
  return mesh;
}

// Returns the unit cube as six squares.
inline Mesh unit_cube() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                   {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

// Returns a torus of quadrilaterals about the z axis, with radii 1 and 0.4.
inline Mesh quad_torus(std::uint32_t around, std::uint32_t across) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const double v = 2 * std::numbers::pi * j / across;
      const double r = 1 + 0.4 * std::cos(v);
      mesh.positions.push_back({r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)});
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return (i % around) * across + j % across; };
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      mesh.add_face(std::array{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

// Returns a prism of height 1 over a polygon in the plane z = 0. The polygon is counter-clockwise seen from above.
inline Mesh prism(const std::vector<Vec3d>& outline) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const Vec3d& p : outline) mesh.positions.push_back(p);
  for (const Vec3d& p : outline) mesh.positions.push_back({p.x, p.y, 1});
  std::vector<std::uint32_t> bottom;
  std::vector<std::uint32_t> top;
  for (std::uint32_t i = 0; i < n; ++i) {
    bottom.push_back(n - 1 - i);
    top.push_back(n + i);
    mesh.add_face(std::array{i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  mesh.add_face(bottom);
  mesh.add_face(top);
  return mesh;
}

// Small surfaces that touch or cross themselves, each with its number of intersecting pairs.

struct DirtyShape {
  std::string name;
  Mesh mesh;
  std::optional<std::size_t> pairs;  // if they can be counted by hand
};

inline Mesh join(Mesh a, const Mesh& b, const Vec3d& moved_by) {
  const auto first = static_cast<std::uint32_t>(a.positions.size());
  for (const Vec3d& p : b.positions) a.positions.push_back(p + moved_by);
  for (std::size_t f = 0; f < b.face_count(); ++f) {
    std::vector<std::uint32_t> face(b.face(f).begin(), b.face(f).end());
    for (std::uint32_t& v : face) v += first;
    a.add_face(face);
  }
  return a;
}

// Returns a sphere with one side pushed out through the other.
inline Mesh pushed_through() {
  Mesh mesh = make_shape(ShapeKind::sphere, 642);
  for (Vec3d& p : mesh.positions) {
    if (p.x > 0.8) p.x -= 2.5;
  }
  return mesh;
}

inline std::vector<DirtyShape> dirty_shapes() {
  const Mesh flat = make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{0, 1, 2}});
  const Mesh small = make_mesh({{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}, {{0, 1, 2}});
  const Mesh upright = make_mesh({{1, 1, -1}, {2, 1, -1}, {1, 1, 1}}, {{0, 1, 2}});
  const Mesh tetrahedron =
      make_mesh({{0, 0, 0}, {1, 0, 1}, {0, 1, 1}, {-1, -1, 1}}, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
  return {
      {"a cube", unit_cube(), 0},
      {"two cubes apart", join(unit_cube(), unit_cube(), {2, 0, 0}), 0},
      {"two cubes that cross", join(unit_cube(), unit_cube(), {0.5, 0.25, 0.125}), {}},
      {"two cubes with a common face", join(unit_cube(), unit_cube(), {1, 0, 0}), {}},
      {"a sphere pushed through itself", pushed_through(), {}},
      // three triangles of each touch in the corner
      {"two tetrahedra, corner in corner",
       join(tetrahedron,
            make_mesh({{0, 0, 0}, {1, 0, -1}, {0, 1, -1}, {-1, -1, -1}}, {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}}),
            {}),
       9},
      {"two triangles, edge on edge", join(flat, make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 0, 4}}, {{0, 1, 2}}), {}), 1},
      {"an edge that crosses an edge", join(flat, make_mesh({{1, -1, 0}, {1, 1, 0}, {1, 0, 5}}, {{0, 1, 2}}), {}), 1},
      {"a corner on a triangle", join(flat, make_mesh({{1, 1, 0}, {1, 2, 1}, {2, 1, 1}}, {{0, 1, 2}}), {}), 1},
      {"a corner just above a triangle",
       join(flat, make_mesh({{1, 1, 0x1p-1000}, {1, 2, 1}, {2, 1, 1}}, {{0, 1, 2}}), {}), 1},
      {"a corner above a triangle", join(flat, make_mesh({{1, 1, 0x1p-200}, {1, 2, 1}, {2, 1, 1}}, {{0, 1, 2}}), {}),
       0},
      {"a triangle through another", join(flat, upright, {}), 1},
      {"a triangle within another, in a plane", join(flat, small, {}), 1},
      {"a triangle around another, in a plane", join(small, flat, {}), 1},
      {"two triangles in a plane, apart", join(flat, small, {2, 2, 0}), 0},
      {"two triangles in a plane, edge on edge", join(flat, small, {1, 0, 0}), 1},
      {"the same three corners twice", make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 2, 0}}), 1},
      {"and turned over", make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}), 1},
      {"neighbours folded flat", make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 0, 3}}), 1},
      {"neighbours in a plane", make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, -1, 0}}, {{0, 1, 2}, {1, 0, 3}}), 0},
      {"neighbours almost folded flat",
       make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1e-30}}, {{0, 1, 2}, {1, 0, 3}}), 0},
      {"a common corner, and crossing",
       make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 1, -1}, {2, 1, 1}}, {{0, 1, 2}, {0, 3, 4}}), 1},
      {"a common corner only",
       make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {-2, -1, -1}, {-2, -1, 1}}, {{0, 1, 2}, {0, 3, 4}}), 0},
      {"a common corner, overlapping in a plane",
       make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {3, 1, 0}, {1, 3, 0}}, {{0, 1, 2}, {0, 3, 4}}), 1},
      {"a common corner, and an edge along a longer one",
       make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 0, 0}, {0, 0, 1}}, {{0, 1, 2}, {0, 3, 4}}), 1},
      {"a triangle without area through another",
       join(flat, make_mesh({{1, 1, -1}, {1, 1, 0}, {1, 1, 1}}, {{0, 1, 2}}), {}), 1},
      {"a triangle that is a point", make_mesh({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}), 1},
      {"a corner twice", make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 1}, {0, 1, 2}}), 1},
  };
}

}  // namespace knead
