// What the evaluation of a field needs of its scalar type besides + - * / and sqrt. Given here for float and double; a
// dual number or a SIMD pack supplies overloads of the same names, found by argument-dependent lookup.
#pragma once

#include <concepts>

namespace knead {

// mask ? a : b; both are evaluated.
template <std::floating_point T>
constexpr T select(bool mask, T a, T b) {
  return mask ? a : b;
}

// a b + c, a b - c and c - a b. Packs round once, as the fused multiply-adds of the machines that have them; all other
// types twice.
template <class T>
constexpr T mul_add(const T& a, const T& b, const T& c) {
  return a * b + c;
}
template <class T>
constexpr T mul_sub(const T& a, const T& b, const T& c) {
  return a * b - c;
}
template <class T>
constexpr T neg_mul_add(const T& a, const T& b, const T& c) {
  return c - a * b;
}

template <class T>
constexpr T minimum(const T& a, const T& b) {
  return select(b < a, b, a);
}

template <class T>
constexpr T maximum(const T& a, const T& b) {
  return select(a < b, b, a);
}

// The nearest integer, ties to even; |x| below 2^22 for float, 2^51 for double. Exact, by the addition of 1.5 *
// 2^digits.
inline float round_to_integer(float x) {
  const float shift = 12582912.0F;
  return (x + shift) - shift;
}
inline double round_to_integer(double x) {
  const double shift = 6755399441055744.0;
  return (x + shift) - shift;
}

// base^exponent by squaring, exponent >= 0.
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
