// Morton codes, sorting along their curve, and the exact test of a ray against a triangle.
#include "math/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace knead {
namespace {

// Inserts two zero bits before each of the lowest 21 bits.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

int sign_of(double x) { return x > 0 ? 1 : (x < 0 ? -1 : 0); }

// Returns the exact sign of a b - c d. A fused multiply-add gives the rounding error of each product exactly. If the
// rounded products are close, their difference is exact, and the errors complete it; otherwise it decides alone.
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
  // The rounding error of `errors`.
  const double subtracted = right_error - errors;
  const double lost = (right_error - (errors + subtracted)) + (subtracted - left_error);
  return -sign_of(lost);
}

// Returns on which side of the z axis the edge from a to b passes: the sign of a x b. If that is zero, returns the sign
// for an axis at (e, e^2) with an infinitesimal e > 0; zero only if a and b are at the same x and y.
int side_of_axis(const Vec3d& a, const Vec3d& b) {
  if (a.x == b.x && a.y == b.y) return 0;
  if (const int sign = sign_of_difference(a.x, b.y, a.y, b.x); sign != 0) return sign;
  if (a.y != b.y) return a.y > b.y ? 1 : -1;
  return b.x > a.x ? 1 : -1;
}

// Returns 1 / x, or 1e300 for 0: a ray along a slab is then inside it exactly if its origin is.
double inverse_of(double x) { return x == 0 ? 1e300 : 1 / x; }

}  // namespace

std::uint64_t morton_code(const std::array<float, 3>& point) {
  std::uint64_t code = 0;
  for (const float x : point) {
    constexpr float cells = 1 << 21;
    const float place = (x * 0.5F + 0.5F) * cells;
    const float cell = place > 0 ? std::min(place, cells - 1) : 0;  // also for NaN
    code = code << 1 | spread(static_cast<std::uint64_t>(cell));
  }
  return code;
}

void sort_along_curve(std::vector<CurvePlace>& places) {
  constexpr std::size_t kMinSizeForBits = 4096;
  if (places.size() < kMinSizeForBits) return std::sort(places.begin(), places.end());
  constexpr int kLowestBit = 30;  // of the highest 33 of 63 bits
  sort_by_bits(places, kLowestBit, [](const CurvePlace& place) { return place.code; });
  for (auto first = places.begin(); first != places.end();) {
    const auto last = std::find_if(first + 1, places.end(), [&](const CurvePlace& place) {
      return place.code >> kLowestBit != first->code >> kLowestBit;
    });
    std::sort(first, last);
    first = last;
  }
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
  rounding_ = 1e-14 * (std::abs(origin.x) + std::abs(origin.y) + std::abs(origin.z));
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

Mat3d inverse(const Mat3d& m) {
  const Vec3d a = cross(m.row1, m.row2);
  const double d = dot(m.row0, a);
  return transposed({a / d, cross(m.row2, m.row0) / d, cross(m.row0, m.row1) / d});
}

Mat3d nearest_rotation(const Mat3d& m) {
  constexpr int kMaxIterations = 40;
  constexpr double kClose = 1e-30;  // the square of a change, after which the next one is beyond rounding
  Mat3d r = m;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Mat3d cofactors{cross(r.row1, r.row2), cross(r.row2, r.row0), cross(r.row0, r.row1)};
    const Mat3d next = (r + cofactors * (1 / dot(r.row0, cofactors.row0))) * 0.5;
    const double change = norm2(next.row0 - r.row0) + norm2(next.row1 - r.row1) + norm2(next.row2 - r.row2);
    r = next;
    if (!(change > kClose)) break;
  }
  return r;
}

Mat3d log_strain(const Mat3d& m) {
  const Mat3d v = m * transposed(nearest_rotation(m));
  return (v + inverse(v) * -1.0) * 0.5;
}

void detail::orthogonalise(std::array<Vec3d, 3>& m) {
  constexpr int kMaxSweeps = 30;
  constexpr double kOrthogonal = 1e-15;  // of the lengths' product
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool is_done = true;
    for (const auto& [i, k] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
      const double a = norm2(m[i]);
      const double b = norm2(m[k]);
      const double c = dot(m[i], m[k]);
      if (!(std::abs(c) > kOrthogonal * std::sqrt(a * b))) continue;
      is_done = false;
      const double zeta = (b - a) / (2 * c);
      const double t = (zeta < 0 ? -1 : 1) / (std::abs(zeta) + std::sqrt(1 + zeta * zeta));
      const double cosine = 1 / std::sqrt(1 + t * t);
      const Vec3d x = m[i];
      const Vec3d y = m[k];
      m[i] = (x - y * t) * cosine;
      m[k] = (y + x * t) * cosine;
    }
    if (is_done) return;
  }
}

}  // namespace knead
