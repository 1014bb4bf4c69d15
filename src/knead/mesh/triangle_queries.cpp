#include "knead/mesh/triangle_queries.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "knead/mesh/predicates.h"

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

// On which side of the z axis the edge from a to b passes: the sign of a x b. Where it is zero, that for an axis at
// (e, e^2) with e > 0 as small as one likes; zero only where a and b are one.
int side_of_axis(const Vec3d& a, const Vec3d& b) {
  if (a.x == b.x && a.y == b.y) return 0;
  const double left = a.x * b.y;
  const double right = a.y * b.x;
  const double difference = left - right;
  constexpr double bound = 8 * std::numeric_limits<double>::epsilon();
  if (std::abs(difference) > bound * (std::abs(left) + std::abs(right))) return difference > 0 ? 1 : -1;
  if (const int sign = orient2d({0, 0, 0}, a, b, 2); sign != 0) return sign;
  if (a.y != b.y) return a.y > b.y ? 1 : -1;
  return b.x > a.x ? 1 : -1;
}

// Of 0 a number so great that only what contains 0 stays within reach.
double inverse_of(double x) { return x == 0 ? 1e300 : 1 / x; }

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
  // In a needle, a, b and c say little: its sides are all that counts.
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

TriangleRay::TriangleRay(const Vec3d& origin, const Vec3d& direction)
    : origin_(origin), inverse_{inverse_of(direction.x), inverse_of(direction.y), inverse_of(direction.z)} {
  std::size_t z = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (std::abs(direction[k]) > std::abs(direction[z])) z = k;
  }
  std::size_t x = (z + 1) % 3;
  std::size_t y = (x + 1) % 3;
  if (direction[z] < 0) std::swap(x, y);  // keeps the sheared space right-handed
  axes_ = {x, y, z};
  shear_ = {direction[x] / direction[z], direction[y] / direction[z], 1 / direction[z]};
  reach_ = 1e-14 * (std::abs(origin.x) + std::abs(origin.y) + std::abs(origin.z));
}

Vec3d TriangleRay::sheared(const Vec3d& p) const {
  const Vec3d q = p - origin_;
  const double height = q[axes_[2]];
  const auto flushed = [](double x) { return std::abs(x) < 0x1p-250 ? 0.0 : x; };
  return {flushed(q[axes_[0]] - shear_.x * height), flushed(q[axes_[1]] - shear_.y * height), shear_.z * height};
}

std::optional<TriangleRay::Meeting> TriangleRay::meet(const std::array<Vec3d, 3>& corners) const {
  const Vec3d a = sheared(corners[0]);
  const Vec3d b = sheared(corners[1]);
  const Vec3d c = sheared(corners[2]);
  const int side = side_of_axis(a, b);
  if (side == 0 || side_of_axis(b, c) != side || side_of_axis(c, a) != side) return std::nullopt;
  const auto weight = [&](const Vec3d& p, const Vec3d& q) { return std::max(0.0, side * (p.x * q.y - p.y * q.x)); };
  const double u = weight(b, c);
  const double v = weight(c, a);
  const double w = weight(a, b);
  const double sum = u + v + w;
  const double t = sum > 0 ? (u * a.z + v * b.z + w * c.z) / sum : (a.z + b.z + c.z) / 3;
  return Meeting{t, side > 0};
}

}  // namespace knead
