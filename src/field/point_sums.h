// The region field of a point set that is stored for speed: sums over several points at a time. Internal to field and
// flow.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "knead/region.h"
#include "knead/vec.h"

namespace knead {

// Weighted points in packs: kPointPack x coordinates, as many y and z coordinates, as many weights, and the next pack.
// The last pack is filled up with points of weight 0 that repeat the first one of the pack.
inline constexpr std::size_t kPointPack = 8;

template <class S>
struct PointPacks {
  std::vector<S> numbers;
  std::size_t count = 0;

  std::size_t pack_count() const { return numbers.size() / (4 * kPointPack); }

  void push_back(const Vec3<S>& p, S weight) {
    const std::size_t lane = count++ % kPointPack;
    if (lane == 0) {
      for (const S value : {p.x, p.y, p.z, S(0)}) numbers.insert(numbers.end(), kPointPack, value);
    }
    S* pack = numbers.data() + numbers.size() - 4 * kPointPack;
    pack[lane] = p.x;
    pack[kPointPack + lane] = p.y;
    pack[2 * kPointPack + lane] = p.z;
    pack[3 * kPointPack + lane] = weight;
  }

  // Of the i-th point's x; the others follow at distances of kPointPack.
  static std::size_t first_number_of(std::size_t i) { return i / kPointPack * 4 * kPointPack + i % kPointPack; }

  Vec3<S> point(std::size_t i) const {
    const S* at = &numbers[first_number_of(i)];
    return {at[0], at[kPointPack], at[2 * kPointPack]};
  }
  S weight(std::size_t i) const { return numbers[first_number_of(i) + 3 * kPointPack]; }
};

// With ratios q_i = scale2 / |d - p_i|^2: value = sum w_i q_i^half, gradient = sum w_i q_i^(half + 1) (d - p_i).
template <class T>
struct PowerSums {
  T value{};
  Vec3<T> gradient;
};

// Sets result = base^exponent for exponent >= 1, by multiplications; also for types that no number converts to. Nothing
// is passed by value here and below, because the instruction set decides how packs are passed.
template <class P>
[[gnu::always_inline]] inline void positive_power(P& result, const P& base, int exponent) {
  P square = base;
  for (; (exponent & 1) == 0; exponent >>= 1) square = square * square;
  result = square;
  while ((exponent >>= 1) != 0) {
    square = square * square;
    if ((exponent & 1) != 0) result = result * square;
  }
}

// Adds one point.
template <class P>
[[gnu::always_inline]] inline void add_power(PowerSums<P>& sums, const Vec3<P>& offset, const P& weight,
                                             const P& scale2, int half) {
  const P ratio = scale2 / (offset.x * offset.x + offset.y * offset.y + offset.z * offset.z);
  P term;
  positive_power(term, ratio, half);
  term = term * weight;
  const P pull = term * ratio;
  sums.value = sums.value + term;
  sums.gradient.x = sums.gradient.x + offset.x * pull;
  sums.gradient.y = sums.gradient.y + offset.y * pull;
  sums.gradient.z = sums.gradient.z + offset.z * pull;
}

// The sums over all points, none of which may be d. Points are added in lanes, and the lanes in a fixed order: the bits
// depend neither on the compiler nor on the instruction set. Time: about 0.2 to 0.3 ns a point in float with AVX2,
// three times as much with SSE2. Defined for float and double.
template <class S>
PowerSums<S> power_sums(const PointPacks<S>& points, const Vec3<S>& d, S scale2, int half);

// The least |d - p_i|^2; at least one point.
template <class S>
S least_squared_distance(const PointPacks<S>& points, const Vec3<S>& d);

// The same at several places at once, each of which adds point after point: faster, with other bits than the above. The
// bits of a place do not depend on the other places.
inline constexpr std::size_t kPlaces = 8;

template <class S>
struct Places {
  std::array<S, kPlaces> x{};
  std::array<S, kPlaces> y{};
  std::array<S, kPlaces> z{};
  std::array<S, kPlaces> scale2{};
};

template <class S>
struct PlacesSums {
  std::array<S, kPlaces> value{};
  std::array<S, kPlaces> gradient_x{};
  std::array<S, kPlaces> gradient_y{};
  std::array<S, kPlaces> gradient_z{};
};

template <class S>
void power_sums(const PointPacks<S>& points, const Places<S>& places, int half, PlacesSums<S>& sums);

template <class S>
using Curves = std::vector<std::vector<Vec3<S>>>;

// r = (sum_i w_i |d - p_i|^-m + sum_k r_k^-m)^(-1/m) over weighted points and curves: that of PointSet if the weights
// are
// 1. Copies share both; neither is null.
template <class S>
struct PackedSet {
  std::shared_ptr<const PointPacks<S>> points;
  std::shared_ptr<const Curves<S>> curves;
  int exponent = 8;
  S scale{0};  // the unit of distances; 0: the least of them, with which nothing overflows
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

// For any other scalar, such as a dual number.
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

// r and grad r from the sums over all elements, in the unit `scale` of lengths.
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
    if (is_sound(r)) return r;  // otherwise d is so near an element that the sums overflow
  }
  const T scale2 = least_squared_distance(set, d);
  if (!(scale2 > T(0))) return {T(0), {T(0), T(0), T(0)}};
  return evaluate_by(set, d, scale2, sqrt(scale2));
}

}  // namespace knead
