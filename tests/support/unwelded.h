// Meshes whose triangles have vertices of their own, as files without an index have them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "knead/mesh.h"

namespace knead::test {

// Returns the mesh with a vertex for each corner.
inline Mesh unwelded(const Mesh& mesh) {
  Mesh result{{}, mesh.face_begin, std::vector<std::uint32_t>(mesh.corner_vertex.size()), {}};
  for (const std::uint32_t v : mesh.corner_vertex) result.positions.push_back(mesh.positions[v]);
  std::iota(result.corner_vertex.begin(), result.corner_vertex.end(), 0U);
  return result;
}

// Returns how far the corners' vertices are from those of the mesh that they come from.
inline double farthest_apart(const Mesh& mesh, std::span<const Vec3d> welded, std::span<const Vec3d> unwelded) {
  double farthest = 0;
  for (std::size_t c = 0; c < unwelded.size(); ++c) {
    farthest = std::max(farthest, norm(unwelded[c] - welded[mesh.corner_vertex[c]]));
  }
  return farthest;
}

}  // namespace knead::test
