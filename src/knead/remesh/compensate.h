// Giving back the volume that the chords of a refined mesh miss. Internal to the remesh room.
#pragma once

#include <vector>

#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// Moves vertices that the deformation moves along their stars' area vectors by their share of what the chords miss:
// for each edge (area vectors of its two faces).(deviation)/3 (method, section 5), half for each end; each by at most
// one and a half times the greatest deviation around. What lies at features, at the border, and at locked vertices
// stays. The shares together are scaled to `missing`, by a quarter at most. Returns by how much
// the volume of the surface grew.
double compensate(Surface& surface, const std::vector<Vec3d>& deviations, const std::vector<bool>& locked,
                  double missing);

// What the chords miss, by the same sum over edges.
double estimate_missing_volume(const Surface& surface, const std::vector<Vec3d>& deviations);

// Volume between the surface and a point that depends on the positions before alone: differences of it are those of
// the whole closed mesh that the surface is a part of.
double enclosed_volume(const Surface& surface, const std::vector<Vec3d>& positions);

}  // namespace knead::remesh_detail
