// From scene coordinates to the renderer's own: the scene's middle at the origin, everything within the unit ball. All
// differences are taken in double, so that tiny shapes and shapes far from the origin keep their digits in float.
#pragma once

#include <array>

#include "knead/render/scene.h"

namespace knead::render {

struct Placement {
  Vec3d center;
  double scale = 1;  // renderer units per scene unit

  Vec3d apply(const Vec3d& p) const { return (p - center) * scale; }
};

// The middle of the box at the origin, its corners on the unit sphere; a box without extent keeps its size.
Placement make_placement(const Box& box);

using Mat4f = std::array<float, 16>;  // by columns, as OpenGL wants it

// The camera in renderer units. A point of the picture (x, y in -1..1) at distance t in front of the eye is
// origin + direction * t, where origin = eye + (x * side + y * top) * (1 - perspective) and
// direction = forward + (x * side + y * top) * perspective.
struct View {
  Placement placement;
  CameraFrame frame;
  Vec3d ground_up;  // unit
  Vec3d eye;
  Vec3d side;
  Vec3d top;
  double near = 0;
  double far = 1;
  bool perspective = false;
  double pixel = 0;  // the size of a sample, at distance 1 in perspective
  Mat4f matrix{};    // to clip space
};

// A ball in renderer units.
struct BoundingBall {
  Vec3d center;
  double radius = 1;
};

// The view by which everything in the ball is seen. samples_high: the rows of samples in the picture. Throws
// InvalidInput for a camera outside its range.
View make_view(const Camera& camera, const Placement& placement, const BoundingBall& shown, double aspect,
               int samples_high);

// Of a scene, which it also places. samples_high: the rows of samples in the picture. Throws InvalidInput for a camera
// outside its range.
View make_view(const Scene& scene, double aspect, int samples_high);

}  // namespace knead::render
