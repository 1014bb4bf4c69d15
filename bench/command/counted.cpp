// Counts the arithmetic of kernels, by packs of one number that count.
#include "yardsticks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "flow/kernels/kernel_source.h"
#include "flow/segment_mover.h"

namespace knead::bench {

namespace {

// The operations since the count was last set to 0.
std::uint64_t& operations() {
  static std::uint64_t count = 0;
  return count;
}

// A pack of one number that counts its operations.
template <class S>
struct CountedScalar {
  using Scalar = S;
  using Mask = detail::LaneMask;
  static constexpr std::size_t kSize = 1;

  S v = 0;

  CountedScalar() = default;
  template <class U>
  requires std::is_arithmetic_v<U>
  explicit CountedScalar(U value) : v(static_cast<S>(value)) {}

  static CountedScalar load(const S* from) { return CountedScalar(*from); }
  void store(S* to) const { *to = v; }

  friend CountedScalar operator+(const CountedScalar& a, const CountedScalar& b) { return count(a.v + b.v, 1); }
  friend CountedScalar operator-(const CountedScalar& a, const CountedScalar& b) { return count(a.v - b.v, 1); }
  friend CountedScalar operator*(const CountedScalar& a, const CountedScalar& b) { return count(a.v * b.v, 1); }
  friend CountedScalar operator/(const CountedScalar& a, const CountedScalar& b) { return count(a.v / b.v, 1); }
  friend CountedScalar operator-(const CountedScalar& a) { return CountedScalar(-a.v); }
  friend Mask operator<(const CountedScalar& a, const CountedScalar& b) { return {a.v < b.v}; }
  friend Mask operator>(const CountedScalar& a, const CountedScalar& b) { return {a.v > b.v}; }
  friend Mask operator<=(const CountedScalar& a, const CountedScalar& b) { return {a.v <= b.v}; }
  friend Mask operator>=(const CountedScalar& a, const CountedScalar& b) { return {a.v >= b.v}; }
  friend Mask operator==(const CountedScalar& a, const CountedScalar& b) { return {a.v == b.v}; }

  friend CountedScalar select(Mask mask, const CountedScalar& a, const CountedScalar& b) { return mask.v ? a : b; }
  friend CountedScalar sqrt(const CountedScalar& a) { return count(std::sqrt(a.v), 1); }
  friend CountedScalar mul_add(const CountedScalar& a, const CountedScalar& b, const CountedScalar& c) {
    return count(std::fma(a.v, b.v, c.v), 2);
  }
  friend CountedScalar mul_sub(const CountedScalar& a, const CountedScalar& b, const CountedScalar& c) {
    return count(std::fma(a.v, b.v, -c.v), 2);
  }
  friend CountedScalar neg_mul_add(const CountedScalar& a, const CountedScalar& b, const CountedScalar& c) {
    return count(std::fma(-a.v, b.v, c.v), 2);
  }
  friend CountedScalar round_to_integer(const CountedScalar& a) { return count(knead::round_to_integer(a.v), 2); }

 private:
  static CountedScalar count(S value, std::uint64_t done) {
    operations() += done;
    return CountedScalar(value);
  }
};

using detail::kBlock;
using detail::kBlocksPerGroup;
using detail::kGroup;

// Points in whole groups, in the layout of advect().
struct Groups {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> z;
  std::vector<std::uint32_t> steps;

  explicit Groups(std::span<const Vec3d> points) {
    const std::size_t padded = (points.size() + kGroup - 1) / kGroup * kGroup;
    x.resize(padded);
    y.resize(padded);
    z.resize(padded);
    steps.resize(padded);
    for (std::size_t i = 0; i < points.size(); ++i) {
      x[i] = points[i].x;
      y[i] = points[i].y;
      z[i] = points[i].z;
    }
  }
};

void move(const detail::SegmentMover& mover, Groups& groups, std::size_t first, std::size_t count) {
  std::array<std::uint64_t, kBlocksPerGroup> members{};
  std::array<std::uint16_t, kBlocksPerGroup> blocks{};
  std::array<double, kBlocksPerGroup> moved{};
  detail::LiveGroup live{{&groups.x[first], &groups.y[first], &groups.z[first]},
                         members.data(),
                         blocks.data(),
                         0,
                         0,
                         &groups.steps[first],
                         moved.data(),
                         {}};
  for (std::size_t block = 0; block * kBlock < count; ++block) {
    const std::size_t points = std::min(kBlock, count - block * kBlock);
    members[block] = points == kBlock ? ~std::uint64_t{0} : (std::uint64_t{1} << points) - 1;
    blocks[static_cast<std::size_t>(live.block_count++)] = static_cast<std::uint16_t>(block);
  }
  mover(live);
}

}  // namespace

}  // namespace knead::bench

namespace knead {

template <>
inline constexpr bool kSinglePrecision<bench::CountedScalar<float>> = true;

}  // namespace knead

namespace knead::bench {

std::uint64_t operations_of(const Flow& flow, std::span<const Vec3d> points, const AdvectOptions& options) {
  const detail::KernelTable counted{"counted",
                                    detail::kernels_of<CountedScalar<float>, detail::ScalarPack<double>>(),
                                    detail::kernels_of<CountedScalar<double>, detail::ScalarPack<double>>(),
                                    {},
                                    {},
                                    {}};
  operations() = 0;
  Groups groups(points);
  for (const Segment& segment : flow.segments) {
    if (!detail::has_pack_kernel(segment)) return 0;
    const detail::SegmentMover mover = detail::make_segment_mover(segment, options, counted);
    for (std::size_t first = 0; first < points.size(); first += kGroup) {
      move(mover, groups, first, std::min(kGroup, points.size() - first));
    }
  }
  return operations();
}

}  // namespace knead::bench
