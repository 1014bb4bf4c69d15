// Packs: several numbers in one register of an instruction set, two such packs as one, and a single number that rounds
// as they do. Internal to flow: only the sources of kernels, which are compiled for that instruction set, include it.
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

// One number with the multiply-adds of packs, for machines without wide registers.
template <class S>
struct ScalarPack {
  using Scalar = S;
  using Mask = LaneMask;
  static constexpr std::size_t kSize = 1;

  S v = 0;

  KNEAD_INLINE ScalarPack() = default;
  template <class U>
  requires std::is_arithmetic_v<U> KNEAD_INLINE explicit ScalarPack(U value) : v(static_cast<S>(value)) {}

  KNEAD_INLINE static ScalarPack load(const S* from) { return ScalarPack(*from); }
  KNEAD_INLINE void store(S* to) const { *to = v; }

  KNEAD_INLINE friend ScalarPack operator+(const ScalarPack& a, const ScalarPack& b) { return ScalarPack(a.v + b.v); }
  KNEAD_INLINE friend ScalarPack operator-(const ScalarPack& a, const ScalarPack& b) { return ScalarPack(a.v - b.v); }
  KNEAD_INLINE friend ScalarPack operator*(const ScalarPack& a, const ScalarPack& b) { return ScalarPack(a.v * b.v); }
  KNEAD_INLINE friend ScalarPack operator/(const ScalarPack& a, const ScalarPack& b) { return ScalarPack(a.v / b.v); }
  KNEAD_INLINE friend ScalarPack operator-(const ScalarPack& a) { return ScalarPack(-a.v); }
  KNEAD_INLINE friend LaneMask operator<(const ScalarPack& a, const ScalarPack& b) { return {a.v < b.v}; }
  KNEAD_INLINE friend LaneMask operator>(const ScalarPack& a, const ScalarPack& b) { return {a.v > b.v}; }
  KNEAD_INLINE friend LaneMask operator<=(const ScalarPack& a, const ScalarPack& b) { return {a.v <= b.v}; }
  KNEAD_INLINE friend LaneMask operator>=(const ScalarPack& a, const ScalarPack& b) { return {a.v >= b.v}; }
  KNEAD_INLINE friend LaneMask operator==(const ScalarPack& a, const ScalarPack& b) { return {a.v == b.v}; }

  KNEAD_INLINE friend ScalarPack select(LaneMask mask, const ScalarPack& a, const ScalarPack& b) {
    return mask.v ? a : b;
  }
  KNEAD_INLINE friend ScalarPack sqrt(const ScalarPack& a) { return ScalarPack(std::sqrt(a.v)); }
  KNEAD_INLINE friend ScalarPack mul_add(const ScalarPack& a, const ScalarPack& b, const ScalarPack& c) {
    return ScalarPack(std::fma(a.v, b.v, c.v));
  }
  KNEAD_INLINE friend ScalarPack mul_sub(const ScalarPack& a, const ScalarPack& b, const ScalarPack& c) {
    return ScalarPack(std::fma(a.v, b.v, -c.v));
  }
  KNEAD_INLINE friend ScalarPack neg_mul_add(const ScalarPack& a, const ScalarPack& b, const ScalarPack& c) {
    return ScalarPack(std::fma(-a.v, b.v, c.v));
  }
  KNEAD_INLINE friend ScalarPack round_to_integer(const ScalarPack& a) {
    return ScalarPack(knead::round_to_integer(a.v));
  }
};

template <class M, std::size_t size>
struct PackPairMask {
  M a;
  M b;

  KNEAD_INLINE friend PackPairMask operator&(const PackPairMask& x, const PackPairMask& y) {
    return {x.a & y.a, x.b & y.b};
  }
  KNEAD_INLINE friend PackPairMask operator|(const PackPairMask& x, const PackPairMask& y) {
    return {x.a | y.a, x.b | y.b};
  }
  KNEAD_INLINE friend PackPairMask operator!(const PackPairMask& x) { return {!x.a, !x.b}; }
  KNEAD_INLINE friend std::uint32_t bits(const PackPairMask& x) { return bits(x.a) | bits(x.b) << size; }
};

// Two packs as one. Each operation is done for both in turn, which hides its latency.
template <class P>
struct PackPair {
  using Scalar = typename P::Scalar;
  using Mask = PackPairMask<typename P::Mask, P::kSize>;
  static constexpr std::size_t kSize = 2 * P::kSize;

  P a;
  P b;

  KNEAD_INLINE PackPair() = default;
  KNEAD_INLINE PackPair(const P& first, const P& second) : a(first), b(second) {}
  template <class U>
  requires std::is_arithmetic_v<U> KNEAD_INLINE explicit PackPair(U value) : a(value), b(value) {}

  KNEAD_INLINE static PackPair load(const Scalar* from) { return {P::load(from), P::load(from + P::kSize)}; }
  KNEAD_INLINE void store(Scalar* to) const {
    a.store(to);
    b.store(to + P::kSize);
  }

  KNEAD_INLINE friend PackPair operator+(const PackPair& x, const PackPair& y) { return {x.a + y.a, x.b + y.b}; }
  KNEAD_INLINE friend PackPair operator-(const PackPair& x, const PackPair& y) { return {x.a - y.a, x.b - y.b}; }
  KNEAD_INLINE friend PackPair operator*(const PackPair& x, const PackPair& y) { return {x.a * y.a, x.b * y.b}; }
  KNEAD_INLINE friend PackPair operator/(const PackPair& x, const PackPair& y) { return {x.a / y.a, x.b / y.b}; }
  KNEAD_INLINE friend PackPair operator-(const PackPair& x) { return {-x.a, -x.b}; }
  KNEAD_INLINE friend Mask operator<(const PackPair& x, const PackPair& y) { return {x.a < y.a, x.b < y.b}; }
  KNEAD_INLINE friend Mask operator>(const PackPair& x, const PackPair& y) { return {x.a > y.a, x.b > y.b}; }
  KNEAD_INLINE friend Mask operator<=(const PackPair& x, const PackPair& y) { return {x.a <= y.a, x.b <= y.b}; }
  KNEAD_INLINE friend Mask operator>=(const PackPair& x, const PackPair& y) { return {x.a >= y.a, x.b >= y.b}; }
  KNEAD_INLINE friend Mask operator==(const PackPair& x, const PackPair& y) { return {x.a == y.a, x.b == y.b}; }
  KNEAD_INLINE friend PackPair select(const Mask& mask, const PackPair& x, const PackPair& y) {
    return {select(mask.a, x.a, y.a), select(mask.b, x.b, y.b)};
  }
  KNEAD_INLINE friend PackPair sqrt(const PackPair& x) { return {sqrt(x.a), sqrt(x.b)}; }
  KNEAD_INLINE friend PackPair mul_add(const PackPair& x, const PackPair& y, const PackPair& z) {
    return {mul_add(x.a, y.a, z.a), mul_add(x.b, y.b, z.b)};
  }
  KNEAD_INLINE friend PackPair mul_sub(const PackPair& x, const PackPair& y, const PackPair& z) {
    return {mul_sub(x.a, y.a, z.a), mul_sub(x.b, y.b, z.b)};
  }
  KNEAD_INLINE friend PackPair neg_mul_add(const PackPair& x, const PackPair& y, const PackPair& z) {
    return {neg_mul_add(x.a, y.a, z.a), neg_mul_add(x.b, y.b, z.b)};
  }
  KNEAD_INLINE friend PackPair minimum(const PackPair& x, const PackPair& y) {
    return {minimum(x.a, y.a), minimum(x.b, y.b)};
  }
  KNEAD_INLINE friend PackPair maximum(const PackPair& x, const PackPair& y) {
    return {maximum(x.a, y.a), maximum(x.b, y.b)};
  }
  KNEAD_INLINE friend PackPair round_to_integer(const PackPair& x) {
    return {round_to_integer(x.a), round_to_integer(x.b)};
  }
};

}  // namespace knead::detail

namespace knead {

template <class P>
inline constexpr bool kSinglePrecision<detail::PackPair<P>> = kSinglePrecision<P>;

template <>
inline constexpr bool kSinglePrecision<detail::ScalarPack<float>> = true;

}  // namespace knead
