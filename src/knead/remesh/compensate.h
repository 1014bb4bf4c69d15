// Restores the volume that the flat triangles of a refined mesh miss. Internal to the remesh room.
#pragma once

#include <vector>

#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// Moves vertices along the area vectors of their stars to add the volume `missing`. Returns the volume added.
//
// An edge misses about (area vectors of its two faces) . (deviation) / 3 (docs/remeshing.md); each end compensates half
// of that. A vertex moves by at most 1.5 times the largest deviation around it. All motions are then scaled to reach
// `missing`; the factor stays between 0.75 and 1.25. Only vertices that the deformation moves are changed; those at
// features, at the border of the patch, and locked ones stay. `deviations` are those of Refinement.
double compensate(Surface& surface, const std::vector<Vec3d>& deviations, const std::vector<bool>& locked,
                  double missing);

// Returns the missing volume as the same sum over edges.
double estimate_missing_volume(const Surface& surface, const std::vector<Vec3d>& deviations);

// Returns the signed volume between the surface with these positions and a fixed point, the mean of surface.before.
// While the border rests, differences of this volume equal those of the whole closed mesh.
double enclosed_volume(const Surface& surface, const std::vector<Vec3d>& positions);

}  // namespace knead::remesh_detail
