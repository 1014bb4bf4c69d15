// Painting along a path on the surface (paper, section 4.2).
#pragma once

#include <vector>

#include "knead/tool/live_surface.h"
#include "knead/tool/stroke.h"

namespace knead {

// The fraction of `outer` over which a path spreads one dab of full depth: the integral of the blend's weight over its
// own range. Along a straight path the dabs' displacements then add up to the depth.
inline constexpr double kDabLength = 17.0 / 35.0;

// Where the dabs of a stroke with a path aim, before they are moved to the surface, and the depth of each.
// The path is a smooth curve through its points (centripetal, third order); its dabs lie evenly along the curve, close
// enough that the result does not depend on their number. One dab of full depth is spread over every kDabLength * outer
// of the path, and one at least, so that a short path is a dab of full depth. Throws InvalidInput for a path that would
// need more than a million dabs.
struct PaintDabs {
  std::vector<Vec3d> aims;
  double depth = 0;
};
PaintDabs paint_dabs(const PaintStroke& stroke);

// Paints: every dab in turn is applied to the surface at the point of it that is closest to the dab's aim at that
// moment, against the normal there. Stops where apply says so. The stroke is valid and has a path. Throws InvalidInput
// for a point cloud without normals, and where the surface has no normal.
void paint_on(const PaintStroke& stroke, const LiveSurface& surface);

}  // namespace knead
