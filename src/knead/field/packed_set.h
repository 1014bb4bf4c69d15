// A point set stored for speed: the same region field as that of PointSet. Internal to field and flow.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "knead/field/point_sums.h"
#include "knead/field/region.h"

namespace knead {

template <class S>
using Curves = std::vector<std::vector<Vec3<S>>>;

// r = (sum_i w_i |d - p_i|^-m + sum_k r_k^-m)^(-1/m) over weighted points and over curves, as PointSet has it where the
// weights are 1. Copies share both; neither is null.
template <class S>
struct PackedSet {
  std::shared_ptr<const PointPacks<S>> points;
  std::shared_ptr<const Curves<S>> curves;
  int exponent = 8;
  S scale{0};  // what distances are measured by; 0: the least of them, which never overflows
};

template <class S>
PackedSet<S> packed(const PointSet<double>& set) {
  PointPacks<S> points;
  Curves<S> curves;
  for (const Vec3d& p : set.points) points.push_back(Vec3<S>(p), S(1));
  for (const auto& curve : set.curves) curves.emplace_back(curve.begin(), curve.end());
  return {std::make_shared<const PointPacks<S>>(std::move(points)),
          std::make_shared<const Curves<S>>(std::move(curves)), set.exponent};
}

// For any scalar, a dual number for example; point_sums.h has float and double.
template <class T, class S>
T least_squared_distance(const PointPacks<S>& points, const Vec3<T>& d) {
  T least = T(std::numeric_limits<S>::max());
  for (std::size_t i = 0; i < points.count; ++i) least = minimum(least, norm2(d - Vec3<T>(points.point(i))));
  return least;
}

template <class T, class S>
PowerSums<T> power_sums(const PointPacks<S>& points, const Vec3<T>& d, const T& scale2, int half) {
  PowerSums<T> sums;
  for (std::size_t i = 0; i < points.count; ++i) {
    add_power(sums, d - Vec3<T>(points.point(i)), T(points.weight(i)), scale2, half);
  }
  return sums;
}

// The true distance of d from the nearest element, squared.
template <class T, class S>
T least_squared_distance(const PackedSet<S>& set, const Vec3<T>& d) {
  T least2 = least_squared_distance(*set.points, d);
  for (const auto& curve : *set.curves) least2 = minimum(least2, squared_distance_to_curve(d, curve));
  return least2;
}

// r and grad r from the sums over all elements, lengths being measured by `scale`.
template <class T>
RegionValue<T> region_of(const PowerSums<T>& sums, int exponent, const T& scale) {
  const T root = inverse_root(sums.value, exponent);
  return {scale * root, sums.gradient * (root / (sums.value * scale))};
}

// Whether the sums have not overflowed.
template <class T>
bool is_sound(const RegionValue<T>& r) {
  return r.value > T(0) && norm2(r.gradient) < T(std::numeric_limits<float>::max());
}

template <class T, class S>
RegionValue<T> evaluate_by(const PackedSet<S>& set, const Vec3<T>& d, const T& scale2, const T& scale) {
  PowerSums<T> sums = power_sums(*set.points, d, scale2, set.exponent / 2);
  for (const auto& curve : *set.curves) {
    const RegionValue<T> r = curve_distance(d, curve);
    const T ratio = scale / r.value;
    T term;
    positive_power(term, ratio, set.exponent);
    sums.value = sums.value + term;
    sums.gradient = sums.gradient + r.gradient * (scale * term * ratio);
  }
  return region_of(sums, set.exponent, scale);
}

// r and grad r at d. Time: as power_sums, plus the curves' segments.
template <class T, class S>
RegionValue<T> evaluate(const PackedSet<S>& set, const Vec3<T>& d, const T& /*t*/) {
  using std::sqrt;
  if (set.scale > S(0)) {
    const RegionValue<T> r = evaluate_by(set, d, T(set.scale * set.scale), T(set.scale));
    if (is_sound(r)) return r;  // else d is so near an element that the sums overflow
  }
  const T scale2 = least_squared_distance(set, d);
  if (!(scale2 > T(0))) return {T(0), {T(0), T(0), T(0)}};
  return evaluate_by(set, d, scale2, sqrt(scale2));
}

}  // namespace knead
