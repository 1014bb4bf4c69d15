// The blend between inner and outer region (paper, Eq. 5), as the weight w = (1 - b)^2 that the evaluation uses.
#pragma once

#include <limits>

#include "knead/math/scalar.h"

namespace knead {

// The values of the region field r between which a field is blended, inner < outer.
template <class S>
struct Thresholds {
  S inner{0};
  S outer{1};

  template <class U>
  explicit operator Thresholds<U>() const {
    return {static_cast<U>(inner), static_cast<U>(outer)};
  }
  friend bool operator==(const Thresholds&, const Thresholds&) = default;
};

// The weight of the inner motion at one point.
template <class T>
struct Weight {
  T value{};       // w, 1 in the inner region, 0 in the outer one
  T derivative{};  // dw/dr, exactly 0 in both
};

// Returns w = (1 - b(s))^2 with b = 4 s^3 - 3 s^4 and s = clamp((r - inner) / (outer - inner), 0, 1), and dw/dr. In
// terms of the rest q = 1 - s: 1 - b = q^2 (6 - 8 q + 3 q^2), which does not cancel near s = 1. The factor of q is
// rounded up, so that q is exactly 1 wherever r <= inner.
template <class T, class S>
Weight<T> blend_weight(const T& r, const Thresholds<S>& thresholds) {
  const S up = S(1) + S(4) * std::numeric_limits<S>::epsilon();
  const S inverse = up / (thresholds.outer - thresholds.inner);
  const T rest = minimum(maximum((T(thresholds.outer) - r) * T(inverse), T(0)), T(1));
  const T s = T(1) - rest;
  const T complement = rest * rest * mul_add(rest, mul_add(T(3), rest, T(-8)), T(6));
  return {complement * complement, complement * (s * s * rest) * T(S(-24) * inverse)};
}

}  // namespace knead
