// Sine and cosine from + - * only: every compiler, machine and SIMD width gets the same bits. Those of libm differ.
#pragma once

#include <initializer_list>
#include <type_traits>

#include "knead/math/scalar.h"

namespace knead {

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

}  // namespace knead
