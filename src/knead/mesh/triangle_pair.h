// Exact tests of one or two triangles (private to this room).
#pragma once

#include <array>

#include "knead/math/vec3.h"
#include "knead/mesh/triangulate.h"

namespace knead {

// The positions of the corners of a triangle, in the range that predicates.h requires.
using Corners = std::array<Vec3d, 3>;

// Returns true if the corners lie on one line, or at one point.
bool are_collinear(const Corners& corners);

// Returns true if two triangles meet in more than their shared vertices and edges (see self_intersections.h). Neither
// may be collinear.
bool meet_beyond_shared(const Triangle& t, const Corners& t_corners, const Triangle& u, const Corners& u_corners);

}  // namespace knead
