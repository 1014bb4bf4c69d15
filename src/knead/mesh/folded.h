// Edges where a surface turns back on itself.
#pragma once

#include <cstddef>

#include "knead/mesh/mesh.h"

namespace knead {

// How many edges have two triangles that agree which side is out and whose normals are more than 170 degrees apart: a
// surface folded like paper. The triangles are those of triangulate(mesh), so an edge may lie within a polygon.
// Triangles without area (see is_degenerate in measures.h) and edges of any other number of triangles are left out.
std::size_t count_folded_edges(const Mesh& mesh);

}  // namespace knead
