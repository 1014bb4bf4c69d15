#include "knead/render/scene.h"

#include <cmath>
#include <numbers>

namespace knead::render {
namespace {

void extend_by_finite(Box& box, const std::vector<Vec3d>& points) {
  for (const Vec3d& p : points) {
    if (is_finite(p)) box.extend(p);
  }
}

}  // namespace

std::vector<Vec3d> ring(const Vec3d& center, const Vec3d& axis, double radius, int points) {
  const Vec3d a = any_orthogonal(axis);
  const Vec3d b = cross(normalized(axis), a);
  std::vector<Vec3d> circle;
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * std::numbers::pi * i / points;
    circle.push_back(center + (a * std::cos(angle) + b * std::sin(angle)) * radius);
  }
  return circle;
}

Box shapes_box(const Scene& scene) {
  Box box;
  for (const Shape& shape : scene.shapes) {
    if (shape.mesh != nullptr) extend_by_finite(box, shape.mesh->positions);
  }
  return box;
}

Box scene_box(const Scene& scene) {
  Box box = shapes_box(scene);
  for (const TranslucentSurface& surface : scene.surfaces) extend_by_finite(box, surface.mesh.positions);
  for (const Line& line : scene.lines) extend_by_finite(box, line.points);
  for (const Arrow& arrow : scene.arrows) extend_by_finite(box, {arrow.from, arrow.to});
  return box;
}

}  // namespace knead::render
