// Cuts polygons into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead {

using Triangle = std::array<std::uint32_t, 3>;  // three vertices, counter-clockwise seen from outside

// Returns the triangles of all faces, in the order of faces. A face of n corners gives n - 2 triangles (none for n <
// 3). Convex polygons are cut as a fan from their first corner, others by ear clipping in the plane of their mean
// normal (Meisters 1975). If no ear is left (the polygon crosses itself or has no area), or after about 10^7 tests, the
// rest of the polygon is cut as a fan. No face is dropped. Throws InvalidInput for faces that are not sound, and for
// positions that are not finite.
std::vector<Triangle> triangulate(const Mesh& mesh);

// Returns the face of each triangle of triangulate(mesh).
std::vector<std::uint32_t> triangle_faces(const Mesh& mesh);

// Appends the triangles of one polygon, which must have at least three corners.
void triangulate_polygon(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon,
                         std::vector<Triangle>& triangles);

// Throws InvalidInput, with the number of the first triangle at fault, unless every triangle has vertices below the
// number of positions, at finite places.
void check_triangles(std::span<const Triangle> triangles, std::span<const Vec3d> positions);

// Calls visit(triangle) for each triangle that triangulate() would return for the mesh with these positions.
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

// Returns the normal of a closed polygon; its length is twice the area. Method: sum of cross products (Newell).
Vec3d polygon_normal(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon);

}  // namespace knead
