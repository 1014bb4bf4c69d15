// Repeats strokes in mirrors and about an axis.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gestures/tools.h"
#include "knead/tool/stroke.h"

namespace knead::studio {

// One image of what a tool does.
struct SymmetryImage {
  RigidMotion motion;
  // Bit mask of the coordinate planes through the origin (1: x, 2: y, 4: z), if the motion is only these; then images
  // are exact. 0: any other motion.
  unsigned planes = 0;
};

// Returns all images but the original. The number of images of a stroke with mirrors and turns is at most
// turns * 2^mirrors - 1.
std::vector<SymmetryImage> images_of(const ToolSettings& settings);

// Returns the file with the mirror image of a stamp's tool in the planes of a bit mask.
using ImageFile = std::function<std::string(const std::string& file, unsigned planes)>;

// Returns the image of a stroke.
Stroke image_of(const Stroke& stroke, const SymmetryImage& image, const ImageFile& image_file);

// Returns the stroke and its images. Images that are the stroke itself or each other, up to `tolerance` in each number,
// count once.
std::vector<Stroke> with_images(const Stroke& stroke, const std::vector<SymmetryImage>& images, double tolerance,
                                const ImageFile& image_file);

// Returns the paint stroke with the images of each sample after it, so that all sides grow together.
PaintStroke with_images(const PaintStroke& stroke, const std::vector<SymmetryImage>& images);

// Returns the start of a drag: in a mirror's plane or on the axis, if it is so near that the tool lies across it.
Vec3d snapped_to_symmetry(Vec3d p, const ToolSettings& settings);

// Returns p in the planes and on the axis in which the first point of the path lies.
Vec3d kept_in_symmetry(Vec3d p, const Vec3d& first, const ToolSettings& settings);

// Returns the planes of the mirrors.
std::vector<Symmetry::Plane> mirror_planes(const ToolSettings& settings);

}  // namespace knead::studio
