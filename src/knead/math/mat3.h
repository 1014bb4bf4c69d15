// A 3x3 matrix over any scalar, stored by rows.
#pragma once

#include "knead/math/vec3.h"

namespace knead {

// Three rows; by default the identity.
template <class T>
struct Mat3 {
  Vec3<T> row0{T(1), T(0), T(0)};
  Vec3<T> row1{T(0), T(1), T(0)};
  Vec3<T> row2{T(0), T(0), T(1)};

  constexpr Mat3() = default;  // the identity
  constexpr Mat3(const Vec3<T>& r0, const Vec3<T>& r1, const Vec3<T>& r2) : row0(r0), row1(r1), row2(r2) {}

  template <class U>
  constexpr explicit Mat3(const Mat3<U>& m) : row0(m.row0), row1(m.row1), row2(m.row2) {}

  // Returns column i, from 0.
  constexpr Vec3<T> column(std::size_t i) const { return {row0[i], row1[i], row2[i]}; }

  friend constexpr Mat3 operator+(const Mat3& a, const Mat3& b) {
    return {a.row0 + b.row0, a.row1 + b.row1, a.row2 + b.row2};
  }
  friend constexpr Mat3 operator*(const Mat3& a, const T& s) { return {a.row0 * s, a.row1 * s, a.row2 * s}; }
  friend constexpr bool operator==(const Mat3&, const Mat3&) = default;
};

// A matrix in double.
using Mat3d = Mat3<double>;

// Returns the matrix times the vector. T may be a dual number or a SIMD pack.
template <class T>
constexpr Vec3<T> operator*(const Mat3<T>& m, const Vec3<T>& v) {
  return {dot(m.row0, v), dot(m.row1, v), dot(m.row2, v)};
}

template <class T>
constexpr Mat3<T> operator*(const Mat3<T>& a, const Mat3<T>& b) {
  const Vec3<T> c0 = b.column(0);
  const Vec3<T> c1 = b.column(1);
  const Vec3<T> c2 = b.column(2);
  return {{dot(a.row0, c0), dot(a.row0, c1), dot(a.row0, c2)},
          {dot(a.row1, c0), dot(a.row1, c1), dot(a.row1, c2)},
          {dot(a.row2, c0), dot(a.row2, c1), dot(a.row2, c2)}};
}

// Returns the sum of the diagonal.
template <class T>
constexpr T trace(const Mat3<T>& m) {
  return m.row0.x + m.row1.y + m.row2.z;
}

// Returns the determinant of m.
template <class T>
constexpr T determinant(const Mat3<T>& m) {
  return dot(m.row0, cross(m.row1, m.row2));
}

// Returns a b^T.
template <class T>
constexpr Mat3<T> outer_product(const Vec3<T>& a, const Vec3<T>& b) {
  return {b * a.x, b * a.y, b * a.z};
}

// Returns the largest sum of absolute values in a row. It bounds |m v| <= sqrt(3) * row_sum_norm(m) * |v|.
inline double row_sum_norm(const Mat3d& m) {
  const auto row = [](const Vec3d& r) { return std::abs(r.x) + std::abs(r.y) + std::abs(r.z); };
  return std::fmax(row(m.row0), std::fmax(row(m.row1), row(m.row2)));
}

// Returns the matrix exponential. Relative error about 1e-14 for norms up to 10.
// Method: Taylor series with scaling and squaring.
inline Mat3d exp(const Mat3d& m) {
  int squarings = 0;
  double scale = 1;
  for (double size = row_sum_norm(m); size > 0.25; size *= 0.5) {
    scale *= 0.5;
    ++squarings;
  }
  const Mat3d small = m * scale;
  Mat3d term;
  Mat3d sum;
  for (int k = 1; k <= 14; ++k) {
    term = term * small * (1.0 / k);
    sum = sum + term;
  }
  for (int i = 0; i < squarings; ++i) sum = sum * sum;
  return sum;
}

}  // namespace knead
