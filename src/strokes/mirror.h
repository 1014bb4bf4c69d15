// The images of strokes that act at the same time (Mirror in stroke.h). Internal to the library.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/flow.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead {

// Returns all images, without the stroke itself: in each plane, and in several planes one after the other.
std::vector<SymmetryImage> images_in(const Mirror& mirror);

// Images whose sizes or speeds differ by less than this fraction count as one.
inline constexpr double kSameImage = 1e-9;
inline bool are_near(const Vec3d& a, const Vec3d& b, double distance) { return norm(a - b) <= distance; }

// Returns a pose or pins with the parts and pins of all images; nothing for other strokes. Parts become places: the
// vertices that they name are looked up among the positions. A part or pin that is its own image counts once; a pin in
// a plane stays in it, and moves to the place in the plane that is nearest to its target. Throws InvalidInput for a
// vertex that does not exist, and for a pose with `exact`.
std::optional<Stroke> with_images(const Stroke& stroke, const Mirror& mirror, std::span<const Vec3d> positions);

// Returns the greatest speed of the sum of a stroke and its images, divided by the greatest speed of one of them alone.
// Measures at places around the tools and throughout their overlap. 1 for a segment that is no sum, and without
// overlap.
double speed_of_images(const Segment& segment);

// Returns the limit cylinders of the stroke and of its images, each once; none where it has none.
std::vector<StrokeCylinder> limit_cylinders_of(const Stroke& stroke, const Mirror& mirror);

}  // namespace knead
