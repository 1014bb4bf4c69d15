// Several numbers in one register, for one instruction set; and one number alone that rounds as they do. Internal to
// the flow room: included by the sources of kernels only, which are compiled for that instruction set.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#if defined(__wasm__)
#include "flow/kernels/pack_wasm.h"
#else
#include "flow/kernels/pack_xsimd.h"
#endif
#include "knead/vec.h"

namespace knead::detail {

struct LaneMask {
  bool v = false;

  KNEAD_INLINE friend LaneMask operator&(LaneMask a, LaneMask b) { return {a.v && b.v}; }
  KNEAD_INLINE friend LaneMask operator|(LaneMask a, LaneMask b) { return {a.v || b.v}; }
  KNEAD_INLINE friend LaneMask operator!(LaneMask a) { return {!a.v}; }
  KNEAD_INLINE friend std::uint32_t bits(LaneMask a) { return a.v ? 1 : 0; }
};

// One number, with the multiply-adds of packs: what a machine without wide registers computes with.
template <class S>
struct Lane {
  using Scalar = S;
  using Mask = LaneMask;
  static constexpr std::size_t kSize = 1;

  S v = 0;

  KNEAD_INLINE Lane() = default;
  template <class U>
  requires std::is_arithmetic_v<U> KNEAD_INLINE explicit Lane(U value) : v(static_cast<S>(value)) {}

  KNEAD_INLINE static Lane load(const S* from) { return Lane(*from); }
  KNEAD_INLINE void store(S* to) const { *to = v; }

  KNEAD_INLINE friend Lane operator+(const Lane& a, const Lane& b) { return Lane(a.v + b.v); }
  KNEAD_INLINE friend Lane operator-(const Lane& a, const Lane& b) { return Lane(a.v - b.v); }
  KNEAD_INLINE friend Lane operator*(const Lane& a, const Lane& b) { return Lane(a.v * b.v); }
  KNEAD_INLINE friend Lane operator/(const Lane& a, const Lane& b) { return Lane(a.v / b.v); }
  KNEAD_INLINE friend Lane operator-(const Lane& a) { return Lane(-a.v); }
  KNEAD_INLINE friend LaneMask operator<(const Lane& a, const Lane& b) { return {a.v < b.v}; }
  KNEAD_INLINE friend LaneMask operator>(const Lane& a, const Lane& b) { return {a.v > b.v}; }
  KNEAD_INLINE friend LaneMask operator<=(const Lane& a, const Lane& b) { return {a.v <= b.v}; }
  KNEAD_INLINE friend LaneMask operator>=(const Lane& a, const Lane& b) { return {a.v >= b.v}; }
  KNEAD_INLINE friend LaneMask operator==(const Lane& a, const Lane& b) { return {a.v == b.v}; }

  KNEAD_INLINE friend Lane select(LaneMask mask, const Lane& a, const Lane& b) { return mask.v ? a : b; }
  KNEAD_INLINE friend Lane sqrt(const Lane& a) { return Lane(std::sqrt(a.v)); }
  KNEAD_INLINE friend Lane mul_add(const Lane& a, const Lane& b, const Lane& c) {
    return Lane(std::fma(a.v, b.v, c.v));
  }
  KNEAD_INLINE friend Lane mul_sub(const Lane& a, const Lane& b, const Lane& c) {
    return Lane(std::fma(a.v, b.v, -c.v));
  }
  KNEAD_INLINE friend Lane neg_mul_add(const Lane& a, const Lane& b, const Lane& c) {
    return Lane(std::fma(-a.v, b.v, c.v));
  }
  KNEAD_INLINE friend Lane round_to_integer(const Lane& a) { return Lane(knead::round_to_integer(a.v)); }
};

template <class M, std::size_t size>
struct TwinMask {
  M a;
  M b;

  KNEAD_INLINE friend TwinMask operator&(const TwinMask& x, const TwinMask& y) { return {x.a & y.a, x.b & y.b}; }
  KNEAD_INLINE friend TwinMask operator|(const TwinMask& x, const TwinMask& y) { return {x.a | y.a, x.b | y.b}; }
  KNEAD_INLINE friend TwinMask operator!(const TwinMask& x) { return {!x.a, !x.b}; }
  KNEAD_INLINE friend std::uint32_t bits(const TwinMask& x) { return bits(x.a) | bits(x.b) << size; }
};

// Two packs as one: each operation is done for both in turn, so that one's latency is filled with the other's work.
template <class P>
struct Twin {
  using Scalar = typename P::Scalar;
  using Mask = TwinMask<typename P::Mask, P::kSize>;
  static constexpr std::size_t kSize = 2 * P::kSize;

  P a;
  P b;

  KNEAD_INLINE Twin() = default;
  KNEAD_INLINE Twin(const P& first, const P& second) : a(first), b(second) {}
  template <class U>
  requires std::is_arithmetic_v<U> KNEAD_INLINE explicit Twin(U value) : a(value), b(value) {}

  KNEAD_INLINE static Twin load(const Scalar* from) { return {P::load(from), P::load(from + P::kSize)}; }
  KNEAD_INLINE void store(Scalar* to) const {
    a.store(to);
    b.store(to + P::kSize);
  }

  KNEAD_INLINE friend Twin operator+(const Twin& x, const Twin& y) { return {x.a + y.a, x.b + y.b}; }
  KNEAD_INLINE friend Twin operator-(const Twin& x, const Twin& y) { return {x.a - y.a, x.b - y.b}; }
  KNEAD_INLINE friend Twin operator*(const Twin& x, const Twin& y) { return {x.a * y.a, x.b * y.b}; }
  KNEAD_INLINE friend Twin operator/(const Twin& x, const Twin& y) { return {x.a / y.a, x.b / y.b}; }
  KNEAD_INLINE friend Twin operator-(const Twin& x) { return {-x.a, -x.b}; }
  KNEAD_INLINE friend Mask operator<(const Twin& x, const Twin& y) { return {x.a < y.a, x.b < y.b}; }
  KNEAD_INLINE friend Mask operator>(const Twin& x, const Twin& y) { return {x.a > y.a, x.b > y.b}; }
  KNEAD_INLINE friend Mask operator<=(const Twin& x, const Twin& y) { return {x.a <= y.a, x.b <= y.b}; }
  KNEAD_INLINE friend Mask operator>=(const Twin& x, const Twin& y) { return {x.a >= y.a, x.b >= y.b}; }
  KNEAD_INLINE friend Mask operator==(const Twin& x, const Twin& y) { return {x.a == y.a, x.b == y.b}; }
  KNEAD_INLINE friend Twin select(const Mask& mask, const Twin& x, const Twin& y) {
    return {select(mask.a, x.a, y.a), select(mask.b, x.b, y.b)};
  }
  KNEAD_INLINE friend Twin sqrt(const Twin& x) { return {sqrt(x.a), sqrt(x.b)}; }
  KNEAD_INLINE friend Twin mul_add(const Twin& x, const Twin& y, const Twin& z) {
    return {mul_add(x.a, y.a, z.a), mul_add(x.b, y.b, z.b)};
  }
  KNEAD_INLINE friend Twin mul_sub(const Twin& x, const Twin& y, const Twin& z) {
    return {mul_sub(x.a, y.a, z.a), mul_sub(x.b, y.b, z.b)};
  }
  KNEAD_INLINE friend Twin neg_mul_add(const Twin& x, const Twin& y, const Twin& z) {
    return {neg_mul_add(x.a, y.a, z.a), neg_mul_add(x.b, y.b, z.b)};
  }
  KNEAD_INLINE friend Twin minimum(const Twin& x, const Twin& y) { return {minimum(x.a, y.a), minimum(x.b, y.b)}; }
  KNEAD_INLINE friend Twin maximum(const Twin& x, const Twin& y) { return {maximum(x.a, y.a), maximum(x.b, y.b)}; }
  KNEAD_INLINE friend Twin round_to_integer(const Twin& x) { return {round_to_integer(x.a), round_to_integer(x.b)}; }
};

}  // namespace knead::detail

namespace knead {

template <class P>
inline constexpr bool kSinglePrecision<detail::Twin<P>> = kSinglePrecision<P>;

template <>
inline constexpr bool kSinglePrecision<detail::Lane<float>> = true;

}  // namespace knead
