// Counts the triangles that a deformation turned over.
#pragma once

#include <cstddef>
#include <span>

#include "knead/mesh/mesh.h"

namespace knead {

// Returns the number of flipped triangles. A triangle is flipped if its normal opposes the mean of the vertex normals
// of its corners (negative dot product) with the positions `after`, but not with `before`. A triangle without area is
// never flipped. Polygons are cut into triangles with the positions `before`. Both spans hold one position per vertex.
std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after);

}  // namespace knead
