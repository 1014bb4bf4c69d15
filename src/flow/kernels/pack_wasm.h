// Packs in the registers of WebAssembly. Internal: pack.h includes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#if defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#include "knead/vec.h"

#define KNEAD_INLINE __attribute__((always_inline)) inline

#if defined(__wasm_simd128__)

// Fused multiply-adds of four floats and of two doubles, composed of other operations (fused_wasm.cpp). If the browser
// has them as single instructions, the page's script replaces the calls (bindings/web/npm/fused.js).
extern "C" {
[[gnu::const]] v128_t knead_fused_floats(v128_t a, v128_t b, v128_t c) noexcept;
[[gnu::const]] v128_t knead_fused_doubles(v128_t a, v128_t b, v128_t c) noexcept;
}

namespace knead::detail {

// The operations of a register of numbers S.
template <class S>
struct WasmLanes;

#define KNEAD_WASM_LANES(S, shape, size, integers)                                            \
  template <>                                                                                 \
  struct WasmLanes<S> {                                                                       \
    static constexpr std::size_t kSize = size;                                                \
    KNEAD_INLINE static v128_t splat(S a) { return wasm_##shape##_splat(a); }                 \
    KNEAD_INLINE static v128_t add(v128_t a, v128_t b) { return wasm_##shape##_add(a, b); }   \
    KNEAD_INLINE static v128_t sub(v128_t a, v128_t b) { return wasm_##shape##_sub(a, b); }   \
    KNEAD_INLINE static v128_t mul(v128_t a, v128_t b) { return wasm_##shape##_mul(a, b); }   \
    KNEAD_INLINE static v128_t div(v128_t a, v128_t b) { return wasm_##shape##_div(a, b); }   \
    KNEAD_INLINE static v128_t neg(v128_t a) { return wasm_##shape##_neg(a); }                \
    KNEAD_INLINE static v128_t sqrt(v128_t a) { return wasm_##shape##_sqrt(a); }              \
    KNEAD_INLINE static v128_t lt(v128_t a, v128_t b) { return wasm_##shape##_lt(a, b); }     \
    KNEAD_INLINE static v128_t gt(v128_t a, v128_t b) { return wasm_##shape##_gt(a, b); }     \
    KNEAD_INLINE static v128_t le(v128_t a, v128_t b) { return wasm_##shape##_le(a, b); }     \
    KNEAD_INLINE static v128_t ge(v128_t a, v128_t b) { return wasm_##shape##_ge(a, b); }     \
    KNEAD_INLINE static v128_t eq(v128_t a, v128_t b) { return wasm_##shape##_eq(a, b); }     \
    KNEAD_INLINE static std::uint32_t bits(v128_t a) { return wasm_##integers##_bitmask(a); } \
  };
KNEAD_WASM_LANES(float, f32x4, 4, i32x4)
KNEAD_WASM_LANES(double, f64x2, 2, i64x2)
#undef KNEAD_WASM_LANES

template <class S>
struct PackMask {
  v128_t v;

  KNEAD_INLINE friend PackMask operator&(const PackMask& a, const PackMask& b) { return {wasm_v128_and(a.v, b.v)}; }
  KNEAD_INLINE friend PackMask operator|(const PackMask& a, const PackMask& b) { return {wasm_v128_or(a.v, b.v)}; }
  KNEAD_INLINE friend PackMask operator!(const PackMask& a) { return {wasm_v128_not(a.v)}; }
  KNEAD_INLINE friend std::uint32_t bits(const PackMask& a) { return WasmLanes<S>::bits(a.v); }
};

// The operations that the evaluation of fields needs (knead/vec.h).
template <class S>
struct Pack {
  using Scalar = S;
  using Mask = PackMask<S>;
  using Lanes = WasmLanes<S>;
  static constexpr std::size_t kSize = Lanes::kSize;

  v128_t v;

  KNEAD_INLINE Pack() : v(Lanes::splat(S(0))) {}
  template <class U>
  requires std::is_arithmetic_v<U> KNEAD_INLINE explicit Pack(U value) : v(Lanes::splat(static_cast<S>(value))) {}
  KNEAD_INLINE explicit Pack(v128_t lanes) : v(lanes) {}

  KNEAD_INLINE static Pack load(const S* from) { return Pack(wasm_v128_load(from)); }
  KNEAD_INLINE void store(S* to) const { wasm_v128_store(to, v); }

  // Reads the four bytes at each offset, as words.
  KNEAD_INLINE static void gather(const std::uint8_t* from, const std::int32_t (&offset)[kSize],
                                  std::uint32_t (&to)[kSize]) {
    for (std::size_t k = 0; k < kSize; ++k) std::memcpy(to + k, from + offset[k], 4);
  }

  // Returns the bytes of this index, 0: the lowest, of words.
  KNEAD_INLINE static Pack from_bytes(const std::uint32_t (&words)[kSize], int index) {
    S numbers[kSize];
    for (std::size_t k = 0; k < kSize; ++k) numbers[k] = static_cast<S>(words[k] >> (8 * index) & 255U);
    return load(numbers);
  }

  KNEAD_INLINE friend Pack operator+(const Pack& a, const Pack& b) { return Pack(Lanes::add(a.v, b.v)); }
  KNEAD_INLINE friend Pack operator-(const Pack& a, const Pack& b) { return Pack(Lanes::sub(a.v, b.v)); }
  KNEAD_INLINE friend Pack operator*(const Pack& a, const Pack& b) { return Pack(Lanes::mul(a.v, b.v)); }
  KNEAD_INLINE friend Pack operator/(const Pack& a, const Pack& b) { return Pack(Lanes::div(a.v, b.v)); }
  KNEAD_INLINE friend Pack operator-(const Pack& a) { return Pack(Lanes::neg(a.v)); }
  KNEAD_INLINE friend Mask operator<(const Pack& a, const Pack& b) { return {Lanes::lt(a.v, b.v)}; }
  KNEAD_INLINE friend Mask operator>(const Pack& a, const Pack& b) { return {Lanes::gt(a.v, b.v)}; }
  KNEAD_INLINE friend Mask operator<=(const Pack& a, const Pack& b) { return {Lanes::le(a.v, b.v)}; }
  KNEAD_INLINE friend Mask operator>=(const Pack& a, const Pack& b) { return {Lanes::ge(a.v, b.v)}; }
  KNEAD_INLINE friend Mask operator==(const Pack& a, const Pack& b) { return {Lanes::eq(a.v, b.v)}; }

  KNEAD_INLINE friend Pack select(const Mask& mask, const Pack& a, const Pack& b) {
    return Pack(wasm_v128_bitselect(a.v, b.v, mask.v));
  }
  KNEAD_INLINE friend Pack sqrt(const Pack& a) { return Pack(Lanes::sqrt(a.v)); }
  KNEAD_INLINE friend Pack mul_add(const Pack& a, const Pack& b, const Pack& c) {
    if constexpr (std::is_same_v<S, float>) {
      return Pack(knead_fused_floats(a.v, b.v, c.v));
    } else {
      return Pack(knead_fused_doubles(a.v, b.v, c.v));
    }
  }
  KNEAD_INLINE friend Pack mul_sub(const Pack& a, const Pack& b, const Pack& c) { return mul_add(a, b, -c); }
  KNEAD_INLINE friend Pack neg_mul_add(const Pack& a, const Pack& b, const Pack& c) { return mul_add(-a, b, c); }
  KNEAD_INLINE friend Pack round_to_integer(const Pack& a) {
    const Pack shift(std::is_same_v<S, float> ? S(12582912.0) : S(6755399441055744.0));
    return (a + shift) - shift;
  }
};

}  // namespace knead::detail

namespace knead {

template <>
inline constexpr bool kSinglePrecision<detail::Pack<float>> = true;

}  // namespace knead

#endif
