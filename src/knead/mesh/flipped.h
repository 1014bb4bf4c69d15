// Counts the triangles that a deformation turned over, and the edges where a surface is folded back on itself.
#pragma once

#include <cstddef>
#include <span>

#include "knead/mesh/mesh.h"

namespace knead {

// Returns the number of flipped triangles. A triangle is flipped if its normal opposes the mean of the vertex normals
// of its corners (negative dot product) with the positions `after`, but not with `before`. A triangle without area is
// never flipped. Polygons are cut into triangles with the positions `before`. Both spans hold one position per vertex.
std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after);

// Returns the number of folded edges. An edge is folded if it has exactly two triangles, these have the same
// orientation, and the angle between their normals is above 170 degrees. The triangles are those of triangulate(mesh),
// so an edge may lie inside a polygon. Triangles without area (see is_degenerate in measures.h) are ignored.
std::size_t count_folded_edges(const Mesh& mesh);

}  // namespace knead
