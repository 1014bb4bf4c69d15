// Painting along a path on the surface (paper, section 4.2).
#pragma once

#include <vector>

#include "knead/tool/live_surface.h"
#include "knead/tool/stroke.h"

namespace knead {

// Returns the fraction of `outer` over which a path spreads one dab of full depth: the integral of the blend's weight
// over its own range, 17/35 for the default falloff. Along a straight path the dabs' displacements then add up to the
// depth. The falloff is from 3 to 7.
double dab_length(int falloff);

// The dabs of a stroke with a path: their places before they are moved to the surface, and the depth of each.
struct PaintDabs {
  std::vector<Vec3d> aims;
  double depth = 0;
};

// Returns the dabs of a stroke with a path. A smooth curve (centripetal, third order) goes through the path's points;
// the dabs lie evenly along it, close enough that the result does not depend on their number. Every dab_length * outer
// of the path gets one dab of full depth in all; a shorter path also gets one. Throws InvalidInput for a path that
// needs more than a million dabs.
PaintDabs paint_dabs(const PaintStroke& stroke);

// Applies one dab after the other: each at the point of the current surface that is closest to the dab's place, against
// the normal there. Stops when apply returns false. The stroke is valid and has a path. Throws InvalidInput for a point
// cloud without normals, and at a place where the surface has no normal.
void paint_on(const PaintStroke& stroke, const LiveSurface& surface);

}  // namespace knead
