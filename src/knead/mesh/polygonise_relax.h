// Private to polygonise: evens out a surface and keeps it on {f = 0}.
#pragma once

#include "knead/mesh/polygonise_dual.h"

namespace knead::polygonise_detail {

// For rounds = 0 does nothing; else moves every vertex onto {f = 0}, then `rounds` times towards the mean of its
// neighbours within the tangent plane and back onto {f = 0}. No vertex goes farther than one cell from where it was,
// and none where |f| would grow; so a function that is rough on the scale of a cell leaves the surface as it was,
// roughly.
void relax(QuadSurface& surface, const ScalarFunction& f, double cell, int rounds);

// Each quadrilateral split along the diagonal that leaves the larger smallest angle.
Mesh split_quads(const QuadSurface& surface);

}  // namespace knead::polygonise_detail
