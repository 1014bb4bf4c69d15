// The functions of a scalar that the evaluation of a field needs besides + - * / and sqrt, for float and double. Dual
// numbers and SIMD packs overload the same names; argument-dependent lookup finds these overloads.
#pragma once

#include <concepts>

#include "knead/math/scalar.h"

namespace knead {

// Returns the same bytes as a value of another type, as bit_cast, which some standard libraries do not have yet.
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

}  // namespace knead
