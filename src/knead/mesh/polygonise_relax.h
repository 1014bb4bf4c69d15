// Private to polygonise: smooths a surface and keeps it on {f = 0}.
#pragma once

#include "knead/mesh/polygonise_dual.h"

namespace knead::polygonise_detail {

// Moves every vertex onto {f = 0}, then `rounds` times towards the mean of its neighbours in the tangent plane and back
// onto {f = 0}. Does nothing for rounds = 0. A vertex moves at most one cell in all, and never where |f| would grow. So
// a function that is rough on the scale of a cell hardly changes the surface.
void relax(QuadSurface& surface, const ScalarFunction& f, double cell, int rounds);

// Returns triangles: each quadrilateral is split along the diagonal that gives the larger smallest angle.
Mesh split_quads(const QuadSurface& surface);

}  // namespace knead::polygonise_detail
