// Exact questions about one triangle or two (private to this room).
#pragma once

#include <array>

#include "knead/math/vec3.h"
#include "knead/mesh/triangulate.h"

namespace knead {

// The positions of a triangle's corners, within the range of predicates.h.
using Corners = std::array<Vec3d, 3>;

// Whether they lie on one line, or in one point.
bool are_collinear(const Corners& corners);

// Whether two triangles, neither collinear, meet beyond what they share (see self_intersections.h).
bool meet_beyond_shared(const Triangle& t, const Corners& t_corners, const Triangle& u, const Corners& u_corners);

}  // namespace knead
