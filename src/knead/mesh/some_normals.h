// Normals of some vertices. Internal to the mesh room.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead {

// Returns the normals of these vertices, to the bit those of vertex_normals(); the numbers ascend. Memory: a bit for
// each vertex of the mesh.
std::vector<Vec3d> normals_of(const Mesh& mesh, std::span<const Vec3d> positions,
                              std::span<const std::uint32_t> vertices);

}  // namespace knead
