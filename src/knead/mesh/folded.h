// Counts the edges where a surface is folded back on itself.
#pragma once

#include <cstddef>

#include "knead/mesh/mesh.h"

namespace knead {

// Returns the number of folded edges. An edge is folded if it has exactly two triangles, these have the same
// orientation, and the angle between their normals is above 170 degrees. The triangles are those of triangulate(mesh),
// so an edge may lie inside a polygon. Triangles without area (see is_degenerate in measures.h) are ignored.
std::size_t count_folded_edges(const Mesh& mesh);

}  // namespace knead
