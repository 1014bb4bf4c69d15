// Small meshes for the tests of this room.
#pragma once

#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "knead/mesh/mesh.h"

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

}  // namespace knead
