// Strokes and their mirror images, which act at the same time.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "knead/tool/barrel.h"
#include "knead/tool/placement.h"
#include "knead/tool/stroke.h"

namespace knead {

// A plane in which a stroke is mirrored.
struct MirrorPlane {
  Vec3d normal{1, 0, 0};  // of any length but 0
  Vec3d point{0, 0, 0};

  friend bool operator==(const MirrorPlane&, const MirrorPlane&) = default;
};

// Up to three planes at right angles to each other; none: no mirror.
using Mirror = std::vector<MirrorPlane>;

// Throws InvalidInput for more than three planes, a number that is not finite, a normal of length 0, and planes that
// are not at right angles.
void validate(const Mirror& mirror);

// Returns the coordinate planes through the origin whose names the text has: "x" is the plane x = 0, "xz" are x = 0 and
// z = 0. Throws InvalidInput for anything but some of the letters x, y and z, each once.
Mirror coordinate_mirror(std::string_view names);

// Returns all images but the stroke itself: in each plane, and in the planes one after the other.
std::vector<SymmetryImage> images_in(const Mirror& mirror);

// Returns the segments of a stroke that reads no surface and of its images: as many as of the stroke alone, each the
// sum of one of the stroke's segments and its images. Images that do the same to every point count once. Pins are
// joined by their images instead, so that all go to their places exactly; a pin in a plane stays in it, and goes to the
// place in the plane that is nearest to its target. Throws InvalidInput as flow_of(stroke), for a mirror that is not
// valid, for a mask or relax, for a grid unless the normals are along axes, and for pins that are each other's images
// but whose targets are not.
Flow flow_of(const Stroke& stroke, const Mirror& mirror);

// Returns a pose with the parts and pins of its images too, all as places: the vertices it names are looked up among
// the positions. What is its own image counts once; a pin in a plane stays in it. Throws InvalidInput for a vertex that
// is not there, and for a pose with `exact`.
PoseStroke with_images(const PoseStroke& stroke, const Mirror& mirror, std::span<const Vec3d> positions);

// Returns the barrels of the stroke and of its images, each once; none where it has none.
std::vector<Barrel> barrels_of(const Stroke& stroke, const Mirror& mirror);

}  // namespace knead
