// How the region field of handles is evaluated; included by region.h.
#pragma once

#include "knead/field/region.h"

namespace knead {

// D and its gradient for the full and the zero set of handles.
template <class T>
struct HandlesDistances {
  RegionValue<T> full;
  RegionValue<T> zero;
};

// Returns both distances at d = x - c(t). The full set has turned with the motion, so d is turned back into its frame;
// the sweep has left the zero set behind.
template <class T, class S, class Set>
HandlesDistances<T> handles_distances(const Handles<S, Set>& region, const Vec3<T>& d, const T& t) {
  const RegionValue<T> zero = evaluate(region.zero, d + Vec3<T>(region.sweep) * t, t);
  if (region.turn_angle == S(0)) return {evaluate(region.full, d, t), zero};
  const Vec3<T> axis(region.turn_axis);
  const SinCos<T> forth = sincos(t * T(region.turn_angle));
  RegionValue<T> full = evaluate(region.full, rotate(d, axis, SinCos<T>{-forth.sin, forth.cos}), t);
  full.gradient = rotate(full.gradient, axis, forth);
  return {full, zero};
}

// Returns r = F / (F + Z) and grad r = (Z grad F - F grad Z) / (F + Z)^2, with F = D_full and Z = D_zero. The kinks of
// F and Z at their points do no harm: dw/dr falls to 0 there, with the square of r and the cube of 1 - r. In single
// precision both distances may be 0 where points of the two sets nearly coincide; such a place rests.
template <class T>
RegionValue<T> region_between(const HandlesDistances<T>& distance) {
  const T& full = distance.full.value;
  const T& zero = distance.zero.value;
  const T sum = full + zero;
  const auto apart = sum > T(0);
  const T inverse = select(apart, T(1) / sum, T(0));
  const Vec3<T> gradient =
      (distance.full.gradient * (zero * inverse) - distance.zero.gradient * (full * inverse)) * inverse;
  return {select(apart, full / sum, T(1)), gradient};
}

template <class T, class S, class Set>
RegionValue<T> evaluate(const Handles<S, Set>& region, const Vec3<T>& d, const T& t) {
  return region_between(handles_distances(region, d, t));
}

}  // namespace knead
