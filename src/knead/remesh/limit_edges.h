// Splits the edges that are longer than their limit after the triangles have been improved. Internal to the remesh
// room.
#pragma once

#include <cstddef>

#include "knead/math/progress.h"
#include "knead/remesh/remesh.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

struct LimitedEdges {
  std::size_t splits = 0;
  bool met = true;  // no edge is longer than the limit
};

// Splits edges with a moved end, or with `whole` all edges, in their middle until none is longer than
// targets.max_edge, the longest first. The surface keeps its form. Locked edges stay as they are, and so does the rest
// when there are targets.max_vertices less `outside` vertices.
LimitedEdges limit_edges(Surface& surface, const RemeshTargets& targets, bool whole, std::size_t outside,
                         const Progress* progress);

}  // namespace knead::remesh_detail
