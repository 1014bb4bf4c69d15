// Repeats strokes in mirrors and about an axis.
#pragma once

#include <optional>
#include <vector>

#include "gestures/tools.h"
#include "knead/stroke.h"

namespace knead::studio {

// Returns all images but the original. The number of images of a stroke with mirrors and turns is at most
// turns * 2^mirrors - 1.
std::vector<SymmetryImage> images_of(const ToolSettings& settings);

// Returns the planes of the mirrors if they are all the images that there are, and at right angles to each other; else
// nothing.
std::optional<Mirror> mirror_of(const ToolSettings& settings);

// Returns the start of a drag: in a mirror's plane or on the axis, if it is so near that the tool lies across it.
Vec3d snapped_to_symmetry(Vec3d p, const ToolSettings& settings);

// Returns p in the planes and on the axis in which the first point of the path lies.
Vec3d kept_in_symmetry(Vec3d p, const Vec3d& first, const ToolSettings& settings);

// Returns the planes of the mirrors.
std::vector<Symmetry::Plane> mirror_planes(const ToolSettings& settings);

}  // namespace knead::studio
