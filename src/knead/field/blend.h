// The blend between inner and outer region (paper, Eq. 5), as the weight w that the evaluation uses.
#pragma once

#include <array>
#include <limits>

#include "knead/math/scalar.h"

namespace knead {

// The shape of a blend: its degree n. w falls from 1 at s = 0 to 0 at s = 1, where s = (r - inner) / (outer - inner).
//   n = 3:       w = (1 - s^3)^3
//   n = 4 to 7:  w = (1 - b)^2; b is the Bernstein polynomial of degree n whose coefficients are 0, 0, 0, 1, 1, ...
// 4 is the paper's blend. w has two continuous derivatives for each n, so the velocity has one. The greater n is, the
// nearer to the inner region w falls.
inline constexpr int kLeastFalloff = 3;
inline constexpr int kDefaultFalloff = 4;
inline constexpr int kGreatestFalloff = 7;

// In the place of a falloff: w = (1 + 5 s)(1 - s)^5, with which a moving ball is the divergence-free kernel of a pin
// (method, section 9; flow/segment.h). Has two continuous derivatives for inner = 0.
inline constexpr int kPinFalloff = 0;
// With these weights the rotation and the strain of a ball are the kernels of a pin's turn: w = (1 - 9/5 s)(1 - s)^3
// for a rotation with gauge 0 and RotationGauge::radial, w = (1 - s)^4 for a strain (docs/mathematics.md).
inline constexpr int kPinRotationFalloff = 1;
inline constexpr int kPinStrainFalloff = 2;

// What is known of the weight of one falloff.
struct FalloffFacts {
  double half;       // the s at which w = 1/2
  double slope;      // the greatest |dw/ds|, rounded up
  double curvature;  // the greatest |d2w/ds2|, rounded up
};

// Of the falloffs 3 to 7.
inline constexpr std::array<FalloffFacts, 5> kFalloffFacts{{{0.5908801132751771, 2.0091, 8.74},
                                                            {0.4867502159528536, 2.0642, 6.95},
                                                            {0.3856147369212866, 2.3897, 10.05},
                                                            {0.3196550856881648, 2.7577, 14.55},
                                                            {0.273098635829133, 3.1415, 19.94}}};

// Returns the facts of a falloff from 3 to 7.
constexpr const FalloffFacts& falloff_facts(int falloff) {
  return kFalloffFacts[static_cast<std::size_t>(falloff - kLeastFalloff)];
}

// The values of the region field r between which a field is blended, inner < outer, and how.
template <class S>
struct Thresholds {
  S inner{0};
  S outer{1};
  int falloff = kDefaultFalloff;

  template <class U>
  explicit operator Thresholds<U>() const {
    return {static_cast<U>(inner), static_cast<U>(outer), falloff};
  }
  friend bool operator==(const Thresholds&, const Thresholds&) = default;
};

// The weight of the inner motion at one point.
template <class T>
struct Weight {
  T value{};       // w, 1 in the inner region, 0 in the outer one
  T derivative{};  // dw/dr, exactly 0 in both
};

// Returns w and dw/dr of a falloff other than 4, from the rest q = 1 - s and inverse = -dq/dr. For n from 4 on,
// 1 - b = q^(n-2) (q^2 + n s q + n (n - 1) / 2 s^2), whose derivative by s is -n (n - 1) (n - 2) / 2 s^2 q^(n-3). Not
// inlined, so that it hardly changes the code of the default.
template <class T, class S>
[[gnu::noinline]] Weight<T> weight_of_falloff(T rest, S inverse, int falloff) {
  const T s = T(1) - rest;
  if (falloff == kPinFalloff) {
    const T fourth = integer_power(rest, 4);
    return {fourth * rest * mul_add(T(5), s, T(1)), fourth * s * T(S(-30) * inverse)};
  }
  if (falloff == kPinRotationFalloff) {
    const T square = rest * rest;
    return {square * rest * (T(1) - s * T(S(1.8))), square * (s * T(S(7.2)) - T(S(4.8))) * T(inverse)};
  }
  if (falloff == kPinStrainFalloff) {
    const T cube = rest * rest * rest;
    return {cube * rest, cube * T(S(-4) * inverse)};
  }
  if (falloff == 3) {
    const T complement = rest * mul_add(rest, rest - T(3), T(3));  // 1 - s^3
    const T square = complement * complement;
    return {square * complement, square * (s * s) * T(S(-9) * inverse)};
  }
  const T power = integer_power(rest, falloff - 3);
  const auto n = static_cast<S>(falloff);
  const T sum = mul_add(rest, mul_add(T(n), s, rest), s * s * T(n * (n - S(1)) * S(0.5)));
  const T complement = power * rest * sum;
  return {complement * complement, complement * (s * s * power) * T(-n * (n - S(1)) * (n - S(2)) * inverse)};
}

// Returns w and dw/dr at r; s is clamped to [0, 1]. For the default, in terms of the rest q = 1 - s:
// 1 - b = q^2 (6 - 8 q + 3 q^2), which does not cancel near s = 1. The factor of q is rounded up, so that q is exactly
// 1 wherever r <= inner.
template <class T, class S>
Weight<T> blend_weight(const T& r, const Thresholds<S>& thresholds) {
  const S up = S(1) + S(4) * std::numeric_limits<S>::epsilon();
  const S inverse = up / (thresholds.outer - thresholds.inner);
  const T rest = minimum(maximum((T(thresholds.outer) - r) * T(inverse), T(0)), T(1));
  if (thresholds.falloff != kDefaultFalloff) [[unlikely]]
    return weight_of_falloff(rest, inverse, thresholds.falloff);
  const T s = T(1) - rest;
  const T complement = rest * rest * mul_add(rest, mul_add(T(3), rest, T(-8)), T(6));
  return {complement * complement, complement * (s * s * rest) * T(S(-24) * inverse)};
}

}  // namespace knead
