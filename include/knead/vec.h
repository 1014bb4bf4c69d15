// Functions of a scalar, vectors, matrices and boxes. The templates take float, double, dual numbers and SIMD packs;
// the latter two overload the functions of a scalar, and argument-dependent lookup finds these overloads.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <span>
#include <type_traits>

namespace knead {

// Returns the same bytes as a value of another type, as the bit_cast that some standard libraries lack.
template <class To, class From>
constexpr To bit_cast(const From& from) {
  return __builtin_bit_cast(To, from);
}

// Returns a where the mask is true, b elsewhere. Both are evaluated.
template <std::floating_point T>
constexpr T select(bool mask, T a, T b) {
  return mask ? a : b;
}

// Returns a b + c; below, a b - c and c - a b. SIMD packs round once where the machine has fused multiply-adds; all
// other types round twice.
template <class T>
constexpr T mul_add(const T& a, const T& b, const T& c) {
  return a * b + c;
}
// Returns a b - c, as mul_add.
template <class T>
constexpr T mul_sub(const T& a, const T& b, const T& c) {
  return a * b - c;
}
// Returns c - a b, as mul_add.
template <class T>
constexpr T neg_mul_add(const T& a, const T& b, const T& c) {
  return c - a * b;
}

// Returns the smaller value; a if they are equal or one is not a number.
template <class T>
constexpr T minimum(const T& a, const T& b) {
  return select(b < a, b, a);
}

// Returns the larger value; a if they are equal or one is not a number.
template <class T>
constexpr T maximum(const T& a, const T& b) {
  return select(a < b, b, a);
}

// Returns the nearest integer, ties to even. |x| must be below 2^22 for float, 2^51 for double. Adding 1.5 * 2^digits
// rounds the fraction away; the result is exact.
inline float round_to_integer(float x) {
  const float shift = 12582912.0F;
  return (x + shift) - shift;
}
// The same for double.
inline double round_to_integer(double x) {
  const double shift = 6755399441055744.0;
  return (x + shift) - shift;
}

// Returns base^exponent for exponent >= 0, by repeated squaring.
template <class T>
constexpr T integer_power(T base, int exponent) {
  T result(1);
  for (; exponent > 0; exponent >>= 1) {
    if ((exponent & 1) != 0) result = result * base;
    base = base * base;
  }
  return result;
}

// Sine and cosine from + - * only: every compiler, machine and SIMD width gets the same bits. Those of libm differ.

// True for float. A SIMD pack of floats specialises this variable.
template <class T>
inline constexpr bool kSinglePrecision = std::is_same_v<T, float>;

// Returns x - quarter pi/2. pi/2 is given in three parts; quarter times the first or the second is exact (Cody and
// Waite, "Software Manual for the Elementary Functions", 1980).
template <class T>
T reduce_by_quarters(const T& x, const T& quarter) {
  if constexpr (kSinglePrecision<T>) {
    return ((x - quarter * T(1.5703125F)) - quarter * T(4.837512969970703125e-4F)) -
           quarter * T(7.54978995489188216e-8F);
  } else {
    return ((x - quarter * T(1.57079632673412561417)) - quarter * T(6.07710050630396597660e-11)) -
           quarter * T(2.02226624879595063154e-21);
  }
}

// Sine and cosine of one angle.
template <class T>
struct SinCos {
  T sin{};
  T cos{};
};

// Returns the sine and cosine of y radians for |y| <= pi/4, by the Taylor series.
template <class T>
SinCos<T> small_sincos(const T& y) {
  const T z = y * y;
  T s = static_cast<T>(-1.0 / 5040.0);
  T c = static_cast<T>(-1.0 / 3628800.0);
  if constexpr (kSinglePrecision<T>) {
    s = mul_add(static_cast<T>(1.0 / 362880.0), z, s);
  } else {
    s = static_cast<T>(1.0 / 355687428096000.0);
    for (const double term :
         {-1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0, -1.0 / 5040.0}) {
      s = mul_add(s, z, static_cast<T>(term));
    }
    c = static_cast<T>(1.0 / 20922789888000.0);
    for (const double term : {-1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0})
      c = mul_add(c, z, static_cast<T>(term));
  }
  s = mul_add(mul_add(s, z, static_cast<T>(1.0 / 120.0)), z, static_cast<T>(-1.0 / 6.0));
  c = mul_add(mul_add(mul_add(c, z, static_cast<T>(1.0 / 40320.0)), z, static_cast<T>(-1.0 / 720.0)), z,
              static_cast<T>(1.0 / 24.0));
  return {mul_add(y, z * s, y), T(1) - mul_sub(z, static_cast<T>(0.5), z * (z * c))};
}

// Returns the sine and cosine of x radians, for |x| <= 1e4. The absolute error is at most 1.5 units in the last place
// of 1: 1.7e-16 for double, 9e-8 for float. Method: reduction modulo pi/2 (see reduce_by_quarters), then small_sincos.
template <class T>
SinCos<T> sincos(const T& x) {
  const T quarter = round_to_integer(x * T(0.63661977236758134308));
  const T y = reduce_by_quarters(x, quarter);
  const SinCos<T> small = small_sincos(y);
  // quarter modulo 4: one of -2, -1, 0, 1, 2.
  const T turn = quarter - T(4) * round_to_integer(quarter * T(0.25));
  const auto odd = turn * turn == T(1);
  const T a = select(odd, small.cos, small.sin);
  const T b = select(odd, small.sin, small.cos);
  const auto half = turn * turn == T(4);
  const T sign_sin = select(half, T(-1), select(turn == T(-1), T(-1), T(1)));
  const T sign_cos = select(half, T(-1), select(turn == T(1), T(-1), T(1)));
  return {sign_sin * a, sign_cos * b};
}

// A 3-vector over any scalar: float, double, a dual number or a SIMD pack.
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

// Returns a unit vector orthogonal to a, equally accurate for all directions of a. The caller guarantees |a| > 0.
inline Vec3d any_orthogonal(const Vec3d& a) {
  const Vec3d helper = std::abs(a.x) < 0.6 * norm(a) ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  return normalized(cross(a, helper));
}

// A 3x3 matrix over any scalar, stored by rows; by default the identity.
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

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

// An axis-aligned box: the points p with min <= p <= max in every coordinate. A new box is empty: min is above max.
struct Box {
  Vec3d min{kInfinity, kInfinity, kInfinity};
  Vec3d max{-kInfinity, -kInfinity, -kInfinity};

  // Returns whether the box contains no point.
  bool empty() const { return !(min.x <= max.x); }
  // Returns the midpoint. The box must not be empty.
  Vec3d center() const { return (min + max) * 0.5; }
  // Returns one of the eight corners: the bits 1, 2 and 4 of `i` choose the maximum of x, y and z.
  Vec3d corner(std::size_t i) const {
    return {(i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y, (i & 4) != 0 ? max.z : min.z};
  }
  // Returns the length of the diagonal; 0 if the box is empty.
  double diagonal() const { return empty() ? 0.0 : norm(max - min); }

  // Grows the box until it contains p.
  void extend(const Vec3d& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
};

// Returns whether a point is in the box.
inline bool contains(const Box& box, const Vec3d& p) {
  return p.x >= box.min.x && p.y >= box.min.y && p.z >= box.min.z && p.x <= box.max.x && p.y <= box.max.y &&
         p.z <= box.max.z;
}

// Returns the distance of a point from the segment between a and b, which may be the same.
inline double distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d e = b - a;
  const double length2 = norm2(e);
  const double along = length2 > 0 ? std::clamp(dot(p - a, e) / length2, 0.0, 1.0) : 0.0;
  return norm(p - a - e * along);
}

// Returns whether two boxes have a common point; touching counts.
inline bool overlap(const Box& a, const Box& b) {
  return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y && a.min.z <= b.max.z &&
         b.min.z <= a.max.z;
}

// Returns whether two points have the same bits: -0 differs from 0, and a NaN can equal a NaN.
inline bool same_bits(const Vec3d& a, const Vec3d& b) {
  using Bits = std::array<std::uint64_t, 3>;
  return bit_cast<Bits>(a) == bit_cast<Bits>(b);
}

// Returns the smallest box that contains every point; empty if there are no points.
inline Box bounding_box(std::span<const Vec3d> points) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  return box;
}

}  // namespace knead
