// A point set laid out for speed: the same region field as PointSet's.
#pragma once

#include <concepts>

#include "knead/field/point_sums.h"
#include "knead/field/region.h"

namespace knead {

// r = (sum_i w_i |d - p_i|^-m + sum_k r_k^-m)^(-1/m) over weighted points and over curves, as PointSet has it where the
// weights are 1. Points must be filled up.
template <class S>
struct PackedSet {
  PointArrays<S> points;
  std::vector<std::vector<Vec3<S>>> curves;
  int exponent = 8;
  S scale{0};  // what distances are measured by; 0: the least of them, which never overflows
};

template <class S>
PackedSet<S> packed(const PointSet<double>& set) {
  PackedSet<S> result;
  result.exponent = set.exponent;
  for (const Vec3d& p : set.points) result.points.push_back(Vec3<S>(p), S(1));
  result.points.fill_up();
  for (const auto& curve : set.curves) result.curves.emplace_back(curve.begin(), curve.end());
  return result;
}

// For any scalar, a dual number for example; point_sums.h has float and double.
template <class T, class S>
T least_squared_distance(const PointArrays<S>& points, const Vec3<T>& d) {
  T least = T(std::numeric_limits<S>::max());
  for (std::size_t i = 0; i < points.size(); ++i) {
    least = minimum(least, norm2(d - Vec3<T>(Vec3<S>{points.x[i], points.y[i], points.z[i]})));
  }
  return least;
}

template <class T, class S>
PowerSums<T> power_sums(const PointArrays<S>& points, const Vec3<T>& d, const T& scale2, int half) {
  PowerSums<T> sums;
  for (std::size_t i = 0; i < points.size(); ++i) {
    add_power(sums, d - Vec3<T>(Vec3<S>{points.x[i], points.y[i], points.z[i]}), T(points.weight[i]), scale2, half);
  }
  return sums;
}

// The squared length by which distances at d are measured: 0 exactly on an element.
template <class T, class S>
T squared_scale(const PackedSet<S>& set, const Vec3<T>& d) {
  if (set.scale > S(0)) return T(set.scale * set.scale);
  T least2 = T(std::numeric_limits<S>::max());
  if (set.points.size() > 0) least2 = least_squared_distance(set.points, d);
  for (const auto& curve : set.curves) least2 = minimum(least2, squared_distance_to_curve(d, curve));
  return least2;
}

// r and grad r at d. Time: as power_sums, plus the curves' segments.
template <class T, class S>
RegionValue<T> evaluate(const PackedSet<S>& set, const Vec3<T>& d, const T& /*t*/) {
  using std::sqrt;
  const T scale2 = squared_scale(set, d);
  if (!(scale2 > T(0))) return {T(0), {T(0), T(0), T(0)}};
  const T scale = sqrt(scale2);
  PowerSums<T> sums = power_sums(set.points, d, scale2, set.exponent / 2);
  sums.gradient = sums.gradient / scale;
  for (const auto& curve : set.curves) {
    const RegionValue<T> r = curve_distance(d, curve);
    const T ratio = scale / r.value;
    T term;
    positive_power(term, ratio, set.exponent);
    sums.value = sums.value + term;
    sums.gradient = sums.gradient + r.gradient * (term * ratio);
  }
  const T root = inverse_root(sums.value, set.exponent);
  return {scale * root, sums.gradient * (root / sums.value)};
}

}  // namespace knead
