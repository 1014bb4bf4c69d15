#include "knead/gpu/exact_ray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace knead::gpu {

namespace {

int sign_of(double x) { return x > 0 ? 1 : (x < 0 ? -1 : 0); }

// The sign of a b - c d, exactly: the products' rounding errors are known to the bit (by multiply-add), their
// difference is exact where they are near each other, and otherwise decides.
int sign_of_difference(double a, double b, double c, double d) {
  const double left = a * b;
  const double right = c * d;
  const double difference = left - right;
  constexpr double bound = 8 * std::numeric_limits<double>::epsilon();
  if (std::abs(difference) > bound * (std::abs(left) + std::abs(right))) return sign_of(difference);
  const double left_error = std::fma(a, b, -left);
  const double right_error = std::fma(c, d, -right);
  const double errors = right_error - left_error;
  if (difference != errors) return difference > errors ? 1 : -1;
  // What rounding took from `errors`.
  const double subtracted = right_error - errors;
  const double lost = (right_error - (errors + subtracted)) + (subtracted - left_error);
  return -sign_of(lost);
}

// On which side of the z axis the edge from a to b passes: the sign of a x b. Where it is zero, that for an axis at
// (e, e^2) with e > 0 as small as one likes; zero only where a and b are one.
int side_of_axis(const Vec3d& a, const Vec3d& b) {
  if (a.x == b.x && a.y == b.y) return 0;
  if (const int sign = sign_of_difference(a.x, b.y, a.y, b.x); sign != 0) return sign;
  if (a.y != b.y) return a.y > b.y ? 1 : -1;
  return b.x > a.x ? 1 : -1;
}

}  // namespace

ExactRay::ExactRay(const Vec3d& origin, const Vec3d& direction) : origin_(origin) {
  for (std::size_t k = 1; k < 3; ++k) {
    if (std::abs(direction[k]) > std::abs(direction[axis_])) axis_ = k;
  }
  is_mirrored_ = direction[axis_] < 0;
  const double along = direction[axis_];
  shear_ = {direction[(axis_ + 1) % 3] / along, direction[(axis_ + 2) % 3] / along, 1 / along};
}

Vec3d ExactRay::sheared(const Vec3d& p) const {
  const Vec3d q = p - origin_;
  const double height = q[axis_];
  const auto flushed = [](double x) { return std::abs(x) < 0x1p-250 ? 0.0 : x; };
  Vec3d result{flushed(q[(axis_ + 1) % 3] - shear_.x * height), flushed(q[(axis_ + 2) % 3] - shear_.y * height),
               shear_.z * height};
  if (is_mirrored_) std::swap(result.x, result.y);  // keeps the sheared space right-handed
  return result;
}

std::optional<ExactRay::Meeting> ExactRay::meet(const std::array<Vec3d, 3>& corners) const {
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

}  // namespace knead::gpu
