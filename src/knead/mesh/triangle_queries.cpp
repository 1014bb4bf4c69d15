#include "knead/mesh/triangle_queries.h"

#include <algorithm>
#include <limits>

namespace knead {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Keeps the nearest of several points of a triangle.
struct Nearest {
  NearTriangle best{{}, {}, kInfinity};
  const std::array<Vec3d, 3>& corners;
  const Vec3d& p;

  void offer(const std::array<double, 3>& barycentric, const Vec3d& point) {
    const double distance2 = norm2(point - p);
    if (distance2 < best.distance2) best = {barycentric, point, distance2};
  }

  void offer_side(std::size_t i, std::size_t j) {
    const Vec3d edge = corners[j] - corners[i];
    const double length2 = norm2(edge);
    const double along = length2 > 0 ? std::clamp(dot(edge, p - corners[i]) / length2, 0.0, 1.0) : 0.0;
    std::array<double, 3> barycentric{};
    barycentric[i] = 1 - along;
    barycentric[j] = along;
    offer(barycentric, along < 1 ? corners[i] + edge * along : corners[j]);
  }
};

}  // namespace

NearTriangle nearest_on_triangle(const std::array<Vec3d, 3>& corners, const Vec3d& p) {
  const Vec3d ab = corners[1] - corners[0];
  const Vec3d ac = corners[2] - corners[0];
  const Vec3d normal = cross(ab, ac);
  const Vec3d ap = p - corners[0];
  const double area2 = norm2(normal);
  const double c = dot(normal, cross(ab, ap));
  const double b = dot(normal, cross(ap, ac));
  const double a = area2 - b - c;
  // In a very thin triangle the weights a, b and c are inaccurate, so its edges decide.
  const double size = norm2(ab) + norm2(ac);
  const bool needle = !(area2 > 1e-16 * size * size);
  Nearest nearest{.corners = corners, .p = p};
  if (!needle && a > 0 && b > 0 && c > 0) {
    const double v = b / area2;
    const double w = c / area2;
    nearest.offer({std::max(0.0, 1 - v - w), v, w}, corners[0] + ab * v + ac * w);
    return nearest.best;
  }
  if (needle || c <= 0) nearest.offer_side(0, 1);
  if (needle || a <= 0) nearest.offer_side(1, 2);
  if (needle || b <= 0) nearest.offer_side(2, 0);
  return nearest.best;
}

}  // namespace knead
