// Sums over packs of points, compiled for the common and for a wider instruction set, with the same bits.
#include "field/point_sums.h"

#include <array>
#include <cstring>
#include <limits>

#include "math/system.h"

// Marks the copies for wider registers.
#if defined(__x86_64__)
#define KNEAD_WIDE [[gnu::target("avx2")]]
#endif

namespace knead {

namespace {

// 8 floats or 4 doubles, which the compiler maps to one register or to two.
template <class S, std::size_t bytes = 32>
struct Lanes {
  using Pack [[gnu::vector_size(bytes)]] = S;
  static constexpr std::size_t kCount = bytes / sizeof(S);
  static_assert(kPointPack % kCount == 0);
};

template <class S, std::size_t bytes = 32>
using Pack = typename Lanes<S, bytes>::Pack;

template <class S>
[[gnu::always_inline]] inline void load(Pack<S>& pack, const S* from) {
  std::memcpy(&pack, from, sizeof pack);
}

template <class S>
[[gnu::always_inline]] inline void fill(Pack<S>& pack, S value) {
  pack = Pack<S>{} + value;
}

// Returns the sum of the lanes, by halves.
template <class S>
[[gnu::always_inline]] inline S added(const Pack<S>& pack) {
  std::array<S, Lanes<S>::kCount> lane{};
  std::memcpy(lane.data(), &pack, sizeof pack);
  for (std::size_t width = lane.size() / 2; width > 0; width /= 2) {
    for (std::size_t i = 0; i < width; ++i) lane[i] += lane[i + width];
  }
  return lane[0];
}

template <class S, int fixed_half>
[[gnu::always_inline]] inline PowerSums<S> sums_of(const PointPacks<S>& points, const Vec3<S>& d, S scale2, int half) {
  Vec3<Pack<S>> at;
  Pack<S> scale;
  fill<S>(at.x, d.x);
  fill<S>(at.y, d.y);
  fill<S>(at.z, d.z);
  fill<S>(scale, scale2);
  PowerSums<Pack<S>> sums;
  for (std::size_t pack = 0; pack < points.pack_count(); ++pack) {
    const S* const numbers = &points.numbers[4 * kPointPack * pack];
    for (std::size_t lane = 0; lane < kPointPack; lane += Lanes<S>::kCount) {
      Vec3<Pack<S>> p;
      Pack<S> weight;
      load<S>(p.x, numbers + lane);
      load<S>(p.y, numbers + kPointPack + lane);
      load<S>(p.z, numbers + 2 * kPointPack + lane);
      load<S>(weight, numbers + 3 * kPointPack + lane);
      Vec3<Pack<S>> offset;
      offset.x = at.x - p.x;
      offset.y = at.y - p.y;
      offset.z = at.z - p.z;
      add_power(sums, offset, weight, scale, fixed_half > 0 ? fixed_half : half);
    }
  }
  return {added<S>(sums.value), {added<S>(sums.gradient.x), added<S>(sums.gradient.y), added<S>(sums.gradient.z)}};
}

// The common exponents without a loop over their bits.
template <class S>
[[gnu::always_inline]] inline PowerSums<S> any_sums(const PointPacks<S>& points, const Vec3<S>& d, S scale2, int half) {
  switch (half) {
    case 3:
      return sums_of<S, 3>(points, d, scale2, half);
    case 4:
      return sums_of<S, 4>(points, d, scale2, half);
    case 8:
      return sums_of<S, 8>(points, d, scale2, half);
    default:
      return sums_of<S, 0>(points, d, scale2, half);
  }
}

// The order does not matter, so the packs are those of the instruction set: g++ compares the lanes of others one by
// one.
template <class S, std::size_t bytes>
[[gnu::always_inline]] inline S any_least(const PointPacks<S>& points, const Vec3<S>& d) {
  using P = Pack<S, bytes>;
  const P at_x = P{} + d.x;
  const P at_y = P{} + d.y;
  const P at_z = P{} + d.z;
  P least = P{} + std::numeric_limits<S>::max();
  for (std::size_t pack = 0; pack < points.pack_count(); ++pack) {
    const S* const numbers = &points.numbers[4 * kPointPack * pack];
    for (std::size_t lane = 0; lane < kPointPack; lane += Lanes<S, bytes>::kCount) {
      P x;
      P y;
      P z;
      std::memcpy(&x, numbers + lane, bytes);
      std::memcpy(&y, numbers + kPointPack + lane, bytes);
      std::memcpy(&z, numbers + 2 * kPointPack + lane, bytes);
      x = at_x - x;
      y = at_y - y;
      z = at_z - z;
      const P square = x * x + y * y + z * z;
      least = square < least ? square : least;
    }
  }
  S result = least[0];
  for (std::size_t i = 1; i < Lanes<S, bytes>::kCount; ++i) result = least[i] < result ? least[i] : result;
  return result;
}

template <class S, int fixed_half>
[[gnu::always_inline]] inline void sums_at(const PointPacks<S>& points, const Places<S>& places, int half,
                                           PlacesSums<S>& result) {
  for (std::size_t lane = 0; lane < kPlaces; lane += Lanes<S>::kCount) {
    Vec3<Pack<S>> at;
    Pack<S> scale2;
    load<S>(at.x, &places.x[lane]);
    load<S>(at.y, &places.y[lane]);
    load<S>(at.z, &places.z[lane]);
    load<S>(scale2, &places.scale2[lane]);
    PowerSums<Pack<S>> sums;
    for (std::size_t i = 0; i < points.count; ++i) {
      const S* const point = &points.numbers[points.first_number_of(i)];
      Vec3<Pack<S>> offset;
      offset.x = at.x - point[0];
      offset.y = at.y - point[kPointPack];
      offset.z = at.z - point[2 * kPointPack];
      const Pack<S> weight = Pack<S>{} + point[3 * kPointPack];
      add_power(sums, offset, weight, scale2, fixed_half > 0 ? fixed_half : half);
    }
    std::memcpy(&result.value[lane], &sums.value, sizeof(Pack<S>));
    std::memcpy(&result.gradient_x[lane], &sums.gradient.x, sizeof(Pack<S>));
    std::memcpy(&result.gradient_y[lane], &sums.gradient.y, sizeof(Pack<S>));
    std::memcpy(&result.gradient_z[lane], &sums.gradient.z, sizeof(Pack<S>));
  }
}

template <class S>
[[gnu::always_inline]] inline void any_sums_at(const PointPacks<S>& points, const Places<S>& places, int half,
                                               PlacesSums<S>& sums) {
  switch (half) {
    case 3:
      return sums_at<S, 3>(points, places, half, sums);
    case 4:
      return sums_at<S, 4>(points, places, half, sums);
    case 8:
      return sums_at<S, 8>(points, places, half, sums);
    default:
      return sums_at<S, 0>(points, places, half, sums);
  }
}

#ifdef KNEAD_WIDE
template <class S>
KNEAD_WIDE PowerSums<S> wide_sums(const PointPacks<S>& points, const Vec3<S>& d, S scale2, int half) {
  return any_sums(points, d, scale2, half);
}

template <class S>
KNEAD_WIDE S wide_least(const PointPacks<S>& points, const Vec3<S>& d) {
  return any_least<S, 32>(points, d);
}

template <class S>
KNEAD_WIDE void wide_sums_at(const PointPacks<S>& points, const Places<S>& places, int half, PlacesSums<S>& sums) {
  any_sums_at(points, places, half, sums);
}
#endif

}  // namespace

template <class S>
PowerSums<S> power_sums(const PointPacks<S>& points, const Vec3<S>& d, S scale2, int half) {
#ifdef KNEAD_WIDE
  if (has_avx2_and_fma()) return wide_sums(points, d, scale2, half);
#endif
  return any_sums(points, d, scale2, half);
}

template <class S>
S least_squared_distance(const PointPacks<S>& points, const Vec3<S>& d) {
#ifdef KNEAD_WIDE
  if (has_avx2_and_fma()) return wide_least(points, d);
#endif
  return any_least<S, 16>(points, d);
}

template <class S>
void power_sums(const PointPacks<S>& points, const Places<S>& places, int half, PlacesSums<S>& sums) {
#ifdef KNEAD_WIDE
  if (has_avx2_and_fma()) return wide_sums_at(points, places, half, sums);
#endif
  any_sums_at(points, places, half, sums);
}

template PowerSums<float> power_sums(const PointPacks<float>&, const Vec3<float>&, float, int);
template PowerSums<double> power_sums(const PointPacks<double>&, const Vec3<double>&, double, int);
template void power_sums(const PointPacks<float>&, const Places<float>&, int, PlacesSums<float>&);
template void power_sums(const PointPacks<double>&, const Places<double>&, int, PlacesSums<double>&);
template float least_squared_distance(const PointPacks<float>&, const Vec3<float>&);
template double least_squared_distance(const PointPacks<double>&, const Vec3<double>&);

}  // namespace knead
