// Triangles that a deformation turned over.
#pragma once

#include <cstddef>
#include <span>

#include "knead/mesh/mesh.h"

namespace knead {

// How many triangles oppose the mean of the vertex normals of their three corners (a negative dot product) with the
// positions `after`, but not with `before`. A triangle without area opposes nothing. The triangles are those of `mesh`
// with the positions `before`; both spans hold one position per vertex.
std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after);

}  // namespace knead
