// The part of a surface that one dab relaxes. Internal to the remesh room.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "knead/mesh/triangulate.h"

namespace knead::remesh_detail {

// The vertices that a dab may move, then those around them; and the triangles at the vertices that may move.
struct RelaxPatch {
  using Neighbours = std::array<std::uint32_t, 2>;

  std::vector<double> weight;          // of each vertex that may move, from 0 to 1
  std::vector<Neighbours> crease;      // of each vertex that may move: its neighbours on a crease; kNone: it is on none
  std::vector<Vec3d> positions;        // of all vertices
  std::vector<Triangle> triangles;     // by these numbers of vertices
  std::vector<std::uint32_t> begin;    // of each vertex that may move, in `corners`; one more
  std::vector<std::uint32_t> corners;  // 3 t + i: the vertex is corner i of triangle t

  std::size_t moving() const { return weight.size(); }
};

// Moves the vertices once towards the means of their neighbours, and keeps the volume (Relaxer).
void relax_once(RelaxPatch& patch, double amount, double surface, int threads);

}  // namespace knead::remesh_detail
