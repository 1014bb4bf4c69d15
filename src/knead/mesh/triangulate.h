// Polygons cut into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead {

using Triangle = std::array<std::uint32_t, 3>;  // three vertices, counter-clockwise seen from outside

// The triangles of every face, face after face: a face of n corners gives n - 2 of them (none for n < 3).
// Triangles and convex polygons are cut as a fan from their first corner, others by ear clipping in the plane of the
// polygon's mean normal (Meisters 1975). A polygon that has no proper cut (self-crossing, flat, without area) or that
// would take more than about 10^7 tests is cut as a fan where ears run out; nothing is dropped, nothing fails.
std::vector<Triangle> triangulate(const Mesh& mesh);

// The face that each triangle of triangulate(mesh) comes from.
std::vector<std::uint32_t> triangle_faces(const Mesh& mesh);

// One polygon with at least three corners: appends its triangles.
void triangulate_polygon(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon,
                         std::vector<Triangle>& triangles);

// Calls visit(triangle) for the triangles of every face as triangulate() cuts them where the vertices are at
// `positions`.
template <class Visit>
void for_each_triangle(const Mesh& mesh, std::span<const Vec3d> positions, Visit visit) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> polygon = mesh.face(f);
    if (polygon.size() == 3) visit(Triangle{polygon[0], polygon[1], polygon[2]});
    if (polygon.size() <= 3) continue;
    triangles.clear();
    triangulate_polygon(positions, polygon, triangles);
    for (const Triangle& t : triangles) visit(t);
  }
}

// The normal of a closed polygon, twice its area long: sum of the cross products of its corners (Newell).
Vec3d polygon_normal(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon);

}  // namespace knead
