// The order of points along a space-filling curve, in which neighbours in space are mostly neighbours; and rays that
// meet triangles exactly; inverses and polar factors of 3x3 matrices; rotations as quaternions.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "knead/vec.h"

namespace knead {

// Maps the points of a box to coordinates from -1 to 1, with the same scale along all axes. The box must not be empty.
// Rounding never reverses the order of two coordinates, so boxes that overlap still overlap after the mapping.
class ToUnit {
 public:
  explicit ToUnit(const Box& box) : center_(box.center()) {
    const Vec3d half = (box.max - box.min) * 0.5;
    const double largest = std::max({half.x, half.y, half.z});
    if (largest > 0) scale_ = 1 / largest;
  }

  std::array<float, 3> operator()(const Vec3d& p) const {
    const Vec3d q = (p - center_) * scale_;
    return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }

 private:
  Vec3d center_;
  double scale_ = 1;
};

// Returns the position on the Morton curve of a point with coordinates from -1 to 1 (21 bits for each coordinate).
std::uint64_t morton_code(const std::array<float, 3>& point);

// Sorts by 33 bits of code(item), from the lowest on; equal items keep their order. Time: linear.
template <class Item, class Code>
void sort_by_bits(std::vector<Item>& items, int lowest, const Code& code) {
  constexpr int bits = 11;
  std::vector<Item> sorted(items.size());
  for (const int shift : {lowest, lowest + bits, lowest + 2 * bits}) {
    const auto digit = [&](const Item& item) { return code(item) >> shift & ((1 << bits) - 1); };
    std::array<std::size_t, (1 << bits) + 1> begin{};
    for (const Item& item : items) ++begin[digit(item) + 1];
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    for (const Item& item : items) sorted[begin[digit(item)]++] = item;
    items.swap(sorted);
  }
}

// The place of something on the Morton curve, and its number.
struct CurvePlace {
  std::uint64_t code = 0;
  std::uint32_t index = 0;

  friend bool operator<(const CurvePlace& a, const CurvePlace& b) {
    return a.code < b.code || (a.code == b.code && a.index < b.index);
  }
};

// Sorts by code, then by index. Time: linear where few share the highest 33 bits of the code.
void sort_along_curve(std::vector<CurvePlace>& places);

// A ray, prepared for tests against many triangles. The decision whether it meets a triangle is exact.
//
// Method: a shear maps the ray to the z axis. A corner always maps to the same point, whichever triangle it is asked
// for. An exact sign then decides on which side of the axis each edge passes. An edge that meets the axis is treated as
// if the axis were moved aside by an infinitesimal distance. So the ray meets the same triangles around an edge or a
// vertex as a ray just beside it. S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1),
// 2013, with exact signs instead of inclusive comparisons.
//
// Coordinates must be finite and either 0 or between 1e-75 and 1e75 in magnitude.
class TriangleRay {
 public:
  TriangleRay(const Vec3d& origin, const Vec3d& direction);

  // Where the ray meets a triangle.
  struct Meeting {
    double t = 0;         // the point is origin + t direction; t has any sign
    bool leaves = false;  // the ray passes to the side that the triangle's normal points to
  };
  // Returns where the line of the ray meets the triangle; nothing if it does not.
  std::optional<Meeting> meet(const std::array<Vec3d, 3>& corners) const;

  // Returns the largest coordinate of the direction: the one that the shear maps to z.
  std::size_t axis() const { return axes_[2]; }

  // Returns the smallest t >= 0 at which the ray is in the box widened by slack; infinity if it misses the box or the
  // box is empty.
  double entry(const Box& box, double slack) const {
    const double pad = slack + rounding_;
    double first = 0;
    double last = kInfinity;
    for (std::size_t k = 0; k < 3; ++k) {
      const double low = (box.min[k] - origin_[k] - pad) * inverse_[k];
      const double high = (box.max[k] - origin_[k] + pad) * inverse_[k];
      first = std::max(first, inverse_[k] > 0 ? low : high);
      last = std::min(last, inverse_[k] > 0 ? high : low);
    }
    return first <= last * (1 + 1e-14) ? first * (1 - 1e-14) : kInfinity;
  }

 private:
  Vec3d sheared(const Vec3d& p) const;

  Vec3d origin_;
  Vec3d inverse_;
  std::array<std::size_t, 3> axes_{};  // which coordinates become x, y and z
  Vec3d shear_;
  double rounding_ = 0;  // a bound on rounding errors that the origin causes
};

// Returns the inverse of a matrix whose determinant is not 0.
Mat3d inverse(const Mat3d& m);

inline Mat3d transposed(const Mat3d& m) { return {m.column(0), m.column(1), m.column(2)}; }

// Returns the rotation R of m = R U, where U is symmetric: the rotation nearest to m, whose determinant is above 0.
// Method: Newton's iteration (Higham 1986).
Mat3d nearest_rotation(const Mat3d& m);

// Returns the logarithm of V of m = V R, where V is symmetric, to third order: the strain of a deformation, in the
// directions after it. The determinant of m must be above 0.
Mat3d log_strain(const Mat3d& m);

namespace detail {

// A rotation: a unit quaternion.
struct Quaternion {
  double w = 1;
  Vec3d v{0, 0, 0};  // the axis times the sine of half the angle
};

// Returns a after b, the inverse rotation, and the rotated vector.
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), b.v * a.w + a.v * b.w + cross(a.v, b.v)};
}
inline Quaternion inverse(const Quaternion& q) { return {q.w, -q.v}; }
inline Vec3d operator*(const Quaternion& q, const Vec3d& p) {
  const Vec3d t = cross(q.v, p) * 2.0;
  return p + t * q.w + cross(q.v, t);
}

// Rotates the vectors, in pairs, until they are orthogonal to each other: M V = U S for the columns of a matrix M.
// Turns by at most 45 degrees each time, so that vectors stay near those that they were. Method: one-sided Jacobi
// rotations.
void orthogonalise(std::array<Vec3d, 3>& m);

}  // namespace detail

}  // namespace knead
