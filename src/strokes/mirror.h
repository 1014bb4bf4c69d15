// The images of strokes that act at the same time (Mirror in stroke.h). Internal to the library.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/flow.h"
#include "knead/stroke.h"
#include "knead/tools.h"
#include "knead/vec.h"

namespace knead {

// Returns all images but the stroke itself: in each plane, and in the planes one after the other.
std::vector<SymmetryImage> images_in(const Mirror& mirror);

// Images whose sizes or speeds differ by less than this part are one.
inline constexpr double kSameImage = 1e-9;
inline bool are_near(const Vec3d& a, const Vec3d& b, double distance) { return norm(a - b) <= distance; }

// Returns a stroke that does what the stroke and its images do together: a pose or pins, with the parts and pins of the
// images. Parts become places: the vertices that they name are looked up among the positions. What is its own image
// counts once; a pin in a plane stays in it, and goes to the place in the plane that is nearest to its target. Nothing
// for other strokes. Throws InvalidInput for a vertex that is not there, and for a pose with `exact`.
std::optional<Stroke> with_images(const Stroke& stroke, const Mirror& mirror, std::span<const Vec3d> positions);

// Returns how many times as fast the sum of a stroke and its images moves points as one of them alone does at most, at
// some places about their tools; 1 for a segment that is no sum, and where they do not overlap.
double speed_of_images(const Segment& segment);

// Returns the limit cylinders of the stroke and of its images, each once; none where it has none.
std::vector<StrokeCylinder> limit_cylinders_of(const Stroke& stroke, const Mirror& mirror);

}  // namespace knead
