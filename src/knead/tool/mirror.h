// The images of strokes that act at the same time (Mirror in stroke.h). Internal to the library.
#pragma once

#include <span>
#include <vector>

#include "knead/tool/barrel.h"
#include "knead/tool/placement.h"
#include "knead/tool/stroke.h"

namespace knead {

// Returns all images but the stroke itself: in each plane, and in the planes one after the other.
std::vector<SymmetryImage> images_in(const Mirror& mirror);

// Returns a pose with the parts and pins of its images too, all as places: the vertices it names are looked up among
// the positions. What is its own image counts once; a pin in a plane stays in it. Throws InvalidInput for a vertex that
// is not there, and for a pose with `exact`.
PoseStroke with_images(const PoseStroke& stroke, const Mirror& mirror, std::span<const Vec3d> positions);

// Returns the barrels of the stroke and of its images, each once; none where it has none.
std::vector<Barrel> barrels_of(const Stroke& stroke, const Mirror& mirror);

}  // namespace knead
