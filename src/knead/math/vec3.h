// A 3-vector over any scalar: float, double, a dual number or a SIMD pack.
#pragma once

#include <cmath>
#include <cstddef>

#include "knead/math/scalar.h"

namespace knead {

// Three components. T may be a dual number or a SIMD pack.
template <class T>
struct Vec3 {
  T x{};
  T y{};
  T z{};

  constexpr Vec3() = default;
  constexpr Vec3(T x_, T y_, T z_) : x(x_), y(y_), z(z_) {}

  // Converts every component, e.g. double to float (rounded to nearest) or a scalar to a dual number.
  template <class U>
  constexpr explicit Vec3(const Vec3<U>& v) : x(static_cast<T>(v.x)), y(static_cast<T>(v.y)), z(static_cast<T>(v.z)) {}

  constexpr T& operator[](std::size_t i) { return i == 0 ? x : (i == 1 ? y : z); }
  constexpr const T& operator[](std::size_t i) const { return i == 0 ? x : (i == 1 ? y : z); }

  constexpr Vec3& operator+=(const Vec3& b) { return *this = *this + b; }
  constexpr Vec3& operator-=(const Vec3& b) { return *this = *this - b; }
  constexpr Vec3& operator*=(const T& s) { return *this = *this * s; }

  friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3 operator*(const Vec3& a, const T& s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3 operator*(const T& s, const Vec3& a) { return a * s; }
  friend constexpr Vec3 operator/(const Vec3& a, const T& s) { return {a.x / s, a.y / s, a.z / s}; }
  // Not defaulted: clang 14 would then demand a constexpr comparison of SIMD packs.
  friend constexpr bool operator==(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
};

// Positions, displacements and directions, in double.
using Vec3d = Vec3<double>;
// The same in float.
using Vec3f = Vec3<float>;

// Returns the scalar product a.b.
template <class T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return mul_add(a.z, b.z, mul_add(a.y, b.y, a.x * b.x));
}

// Returns the vector product a x b.
template <class T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {mul_sub(a.y, b.z, a.z * b.y), mul_sub(a.z, b.x, a.x * b.z), mul_sub(a.x, b.y, a.y * b.x)};
}

// Returns a s + b.
template <class T>
constexpr Vec3<T> mul_add(const Vec3<T>& a, const T& s, const Vec3<T>& b) {
  return {mul_add(a.x, s, b.x), mul_add(a.y, s, b.y), mul_add(a.z, s, b.z)};
}

// Returns b - a s.
template <class T>
constexpr Vec3<T> neg_mul_add(const Vec3<T>& a, const T& s, const Vec3<T>& b) {
  return {neg_mul_add(a.x, s, b.x), neg_mul_add(a.y, s, b.y), neg_mul_add(a.z, s, b.z)};
}

// Returns a where the mask is true, b elsewhere.
template <class Mask, class T>
constexpr Vec3<T> select(const Mask& mask, const Vec3<T>& a, const Vec3<T>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

// Returns the squared length of a.
template <class T>
constexpr T norm2(const Vec3<T>& a) {
  return dot(a, a);
}

// Returns the length of a.
template <class T>
T norm(const Vec3<T>& a) {
  using std::sqrt;
  return sqrt(norm2(a));
}

// Returns a / |a|. The caller guarantees |a| > 0.
template <class T>
Vec3<T> normalized(const Vec3<T>& a) {
  return a / norm(a);
}

// Returns whether no component is infinite or not a number.
inline bool is_finite(const Vec3d& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

// Returns a unit vector orthogonal to a, without loss of accuracy for any direction of a. The caller guarantees |a| >
// 0.
inline Vec3d any_orthogonal(const Vec3d& a) {
  const Vec3d helper = std::abs(a.x) < 0.6 * norm(a) ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  return normalized(cross(a, helper));
}

}  // namespace knead
