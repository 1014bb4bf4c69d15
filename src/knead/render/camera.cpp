#include "knead/render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace knead::render {

CameraFrame camera_frame(const Camera& camera) {
  const Vec3d forward = normalized(camera.target - camera.eye);
  Vec3d right = cross(forward, camera.up);
  if (!(norm(right) > 1e-9 * norm(camera.up))) right = any_orthogonal(forward);
  right = normalized(right);
  return {right, cross(right, forward), forward};
}

namespace {

// The eight corners of the box relative to its centre, along the frame's axes.
template <class F>
void for_each_corner(const Box& box, const CameraFrame& frame, F&& visit) {
  const Vec3d half = (box.max - box.min) * 0.5;
  for (int i = 0; i < 8; ++i) {
    const Vec3d corner{(i & 1) != 0 ? half.x : -half.x, (i & 2) != 0 ? half.y : -half.y,
                       (i & 4) != 0 ? half.z : -half.z};
    visit(Vec3d{dot(corner, frame.right), dot(corner, frame.up), dot(corner, frame.forward)});
  }
}

}  // namespace

Camera fit_camera(const Box& box, const Vec3d& direction, const Vec3d& up, double aspect, const FitOptions& options) {
  const Box fitted = box.empty() ? Box{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}} : box;
  const double usable = std::max(0.05, 1 - 2 * options.margin);
  Camera camera;
  camera.projection = options.projection;
  camera.target = fitted.center();
  camera.up = up;
  camera.eye = camera.target - direction;
  const CameraFrame frame = camera_frame(camera);
  // A single point has no size; far from the origin, the eye must still differ from it.
  const double least = 1e-9 * norm(camera.target);
  const double size = fitted.diagonal() > least ? fitted.diagonal() : std::max(least, 1.0);
  double half_height = 0;
  double distance = size;
  if (options.projection == Projection::orthographic) {
    for_each_corner(fitted, frame, [&](const Vec3d& c) {
      half_height = std::max({half_height, std::abs(c.y) / usable, std::abs(c.x) / (usable * aspect)});
    });
  } else {
    // |y| <= (distance + z) tan(half angle) for every corner, and the same for x.
    const double slope = std::tan(0.5 * std::clamp(options.field_of_view_deg, 1.0, 150.0) * std::numbers::pi / 180);
    for_each_corner(fitted, frame, [&](const Vec3d& c) {
      const double reach = std::max(std::abs(c.y), std::abs(c.x) / aspect) / (usable * slope);
      distance = std::max(distance, reach - c.z);
    });
    half_height = distance * slope;
  }
  camera.height = half_height > 0 ? 2 * half_height : 2 * size;
  camera.eye = camera.target - frame.forward * distance;
  return camera;
}

}  // namespace knead::render
