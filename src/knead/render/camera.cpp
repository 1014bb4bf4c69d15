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

namespace {

// The range of a number over all points.
struct Range {
  double least = Box::kInfinity;
  double greatest = -Box::kInfinity;

  void extend(double x) {
    least = std::min(least, x);
    greatest = std::max(greatest, x);
  }
  double middle() const { return 0.5 * (least + greatest); }
  double extent() const { return greatest - least; }
};

// How far the camera goes aside, up and back from the box's centre. slope_x, slope_y: half the picture's sides at
// distance 1. From distance d behind the centre, a point is within the picture's right side if x - aside <= (d + z)
// slope_x, and likewise for the others: each side asks for a distance, and opposite sides share it evenly.
Vec3d perspective_place(std::span<const Vec3d> points, const Vec3d& center, const CameraFrame& frame, double slope_x,
                        double slope_y) {
  double right = -Box::kInfinity;
  double left = -Box::kInfinity;
  double above = -Box::kInfinity;
  double below = -Box::kInfinity;
  double nearest = Box::kInfinity;
  for (const Vec3d& p : points) {
    const Vec3d q = p - center;
    const double x = dot(q, frame.right) / slope_x;
    const double y = dot(q, frame.up) / slope_y;
    const double z = dot(q, frame.forward);
    right = std::max(right, x - z);
    left = std::max(left, -x - z);
    above = std::max(above, y - z);
    below = std::max(below, -y - z);
    nearest = std::min(nearest, z);
  }
  const double distance = std::max({0.5 * (right + left), 0.5 * (above + below), -nearest});
  return {0.5 * (right - left) * slope_x, 0.5 * (above - below) * slope_y, distance};
}

}  // namespace

Camera fit_points(std::span<const Vec3d> points, const Vec3d& direction, const Vec3d& up, double aspect,
                  const FitOptions& options) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  // The camera for the box shows every shape; what follows only comes closer.
  Camera camera = fit_camera(box, direction, up, aspect, options);
  if (box.empty() || !(box.diagonal() > 1e-9 * norm(camera.target))) return camera;
  const CameraFrame frame = camera_frame(camera);
  const double usable = std::max(0.05, 1 - 2 * options.margin);
  const double distance = norm(camera.eye - camera.target);
  const Vec3d center = camera.target;
  if (options.projection == Projection::orthographic) {
    Range x;
    Range y;
    for (const Vec3d& p : points) {
      x.extend(dot(p - center, frame.right));
      y.extend(dot(p - center, frame.up));
    }
    const double height = std::max(y.extent(), x.extent() / aspect) / usable;
    if (!(height > 0)) return camera;
    camera.height = height;
    camera.target = center + frame.right * x.middle() + frame.up * y.middle();
    camera.eye = camera.target - frame.forward * distance;
    return camera;
  }
  const double slope = 0.5 * camera.height / distance;
  const Vec3d place = perspective_place(points, center, frame, usable * slope * aspect, usable * slope);
  if (!(place.z > 0)) return camera;
  camera.target = center + frame.right * place.x + frame.up * place.y;
  camera.eye = camera.target - frame.forward * place.z;
  camera.height = 2 * place.z * slope;
  return camera;
}

}  // namespace knead::render
