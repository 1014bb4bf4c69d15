#include "gestures/screen.h"

#include <cmath>

namespace knead::studio {

namespace {

constexpr double kParallel = 1e-6;

double target_distance(const Screen& screen) { return norm(screen.camera.target - screen.camera.eye); }

bool is_perspective(const Screen& screen) { return screen.camera.projection == render::Projection::perspective; }

// Scene units a pixel covers in the plane through the target.
double target_pixel(const Screen& screen) { return screen.camera.height / screen.height; }

}  // namespace

Ray ray_through(const Screen& screen, double x, double y) {
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const Vec3d aside =
      (frame.right * (x - 0.5 * screen.width) - frame.up * (y - 0.5 * screen.height)) * target_pixel(screen);
  if (!is_perspective(screen)) return {screen.camera.eye + aside, frame.forward};
  return {screen.camera.eye, normalized(screen.camera.target + aside - screen.camera.eye)};
}

std::optional<Pixel> pixel_of(const Screen& screen, const Vec3d& p) {
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const Vec3d from_eye = p - screen.camera.eye;
  const double depth = dot(from_eye, frame.forward);
  if (is_perspective(screen) && !(depth > 0)) return std::nullopt;
  const double scale = (is_perspective(screen) ? target_distance(screen) / depth : 1) / target_pixel(screen);
  return Pixel{0.5 * screen.width + dot(from_eye, frame.right) * scale,
               0.5 * screen.height - dot(from_eye, frame.up) * scale};
}

double pixel_size(const Screen& screen, const Vec3d& p) {
  if (!is_perspective(screen)) return target_pixel(screen);
  const double depth = dot(p - screen.camera.eye, render::camera_frame(screen.camera).forward);
  return target_pixel(screen) * std::max(depth / target_distance(screen), 1e-6);
}

// By the number of edges that a ray to the right crosses.
bool is_within(std::span<const Pixel> line, const Pixel& p) {
  bool is_inside = false;
  for (std::size_t i = 0, before = line.size() - 1; i < line.size(); before = i++) {
    const Pixel& a = line[i];
    const Pixel& b = line[before];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if (p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) is_inside = !is_inside;
  }
  return is_inside;
}

std::optional<Vec3d> on_plane(const Ray& ray, const Vec3d& point, const Vec3d& normal) {
  const double slope = dot(ray.direction, normal);
  if (std::abs(slope) < kParallel * norm(normal)) return std::nullopt;
  const double t = dot(point - ray.origin, normal) / slope;
  if (!(t > 0)) return std::nullopt;
  return ray.origin + ray.direction * t;
}

std::optional<Vec3d> on_line(const Ray& ray, const Vec3d& point, const Vec3d& direction) {
  const Vec3d u = normalized(direction);
  const double across = dot(u, ray.direction);
  const double sine2 = 1 - across * across;
  if (sine2 < kParallel) return std::nullopt;
  const Vec3d gap = ray.origin - point;
  return point + u * ((dot(gap, u) - across * dot(gap, ray.direction)) / sine2);
}

}  // namespace knead::studio
