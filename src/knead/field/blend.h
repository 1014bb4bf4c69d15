// The blend between inner and outer region (paper, Eq. 5), as the weight w = (1 - b)^2 that the evaluation uses.
#pragma once

#include "knead/math/scalar.h"

namespace knead {

// Values of the region field r between which a field is blended: inner < outer.
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

template <class T>
struct Weight {
  T value{};       // w, 1 in the inner region, 0 in the outer one
  T derivative{};  // dw/dr, exactly 0 in both
};

// w = (1 - b(s))^2 with b = 4 s^3 - 3 s^4 and s = clamp((r - inner) / (outer - inner), 0, 1), and dw/dr. 1 - b is
// evaluated as (1 - s)^2 (1 + 2 s + 3 s^2), which does not cancel near s = 1.
template <class T, class S>
Weight<T> blend_weight(const T& r, const Thresholds<S>& thresholds) {
  const S width = thresholds.outer - thresholds.inner;
  T s = (r - T(thresholds.inner)) / T(width);
  s = minimum(maximum(s, T(0)), T(1));
  const T rest = T(1) - s;
  const T complement = rest * rest * (T(1) + s * (T(2) + T(3) * s));
  const T slope = T(12) * s * s * rest;
  return {complement * complement, T(-2) * complement * slope / T(width)};
}

}  // namespace knead
