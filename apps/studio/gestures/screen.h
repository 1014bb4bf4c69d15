// From the view's pixels into the scene and back.
#pragma once

#include <optional>
#include <span>

#include "knead/render.h"
#include "knead/vec.h"

namespace knead::studio {

struct Ray {
  Vec3d origin;
  Vec3d direction;  // a unit vector
};

// A camera and the size of the view that it fills, in pixels. Places are from the upper left corner, right and down.
struct Screen {
  render::Camera camera;
  int width = 1;
  int height = 1;
};

struct Pixel {
  double x = 0;
  double y = 0;
};

Ray ray_through(const Screen& screen, double x, double y);

// Where a point is seen; nothing for one behind the eye.
std::optional<Pixel> pixel_of(const Screen& screen, const Vec3d& p);

// Returns whether a closed line goes round a pixel, an odd number of times.
bool is_within(std::span<const Pixel> line, const Pixel& p);

// The length that one pixel covers at the depth of a point.
double pixel_size(const Screen& screen, const Vec3d& p);

// Where the ray meets a plane; nothing where they are parallel or the plane is behind.
std::optional<Vec3d> on_plane(const Ray& ray, const Vec3d& point, const Vec3d& normal);

// The point of the line {point + s direction} that is nearest to the ray; nothing where they are parallel.
std::optional<Vec3d> on_line(const Ray& ray, const Vec3d& point, const Vec3d& direction);

}  // namespace knead::studio
