// Several numbers in one register of WebAssembly. It has no fused multiply-adds; they are composed of its operations,
// with the bits of those of other machines. Internal to the flow room: pack.h includes it.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#if defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#include "knead/math/scalar.h"
#include "knead/math/sincos.h"

#define KNEAD_INLINE __attribute__((always_inline)) inline

#if defined(__wasm_simd128__)

namespace knead::detail {

// a + b in double, rounded to odd: rounding this once more, to fewer digits, gives the sum's own rounding (Boldo and
// Melquiond, Emulation of FMA and correctly rounded sums, 2008).
KNEAD_INLINE v128_t sum_to_odd(v128_t a, v128_t b) {
  const v128_t sum = wasm_f64x2_add(a, b);
  const v128_t part = wasm_f64x2_sub(sum, a);
  const v128_t error = wasm_f64x2_add(wasm_f64x2_sub(a, wasm_f64x2_sub(sum, part)), wasm_f64x2_sub(b, part));  // exact
  const v128_t zero = wasm_f64x2_splat(0);
  const v128_t one = wasm_i64x2_splat(1);
  const v128_t is_inexact = wasm_v128_or(wasm_f64x2_lt(error, zero), wasm_f64x2_gt(error, zero));
  const v128_t is_even = wasm_i64x2_eq(wasm_v128_and(sum, one), wasm_i64x2_splat(0));
  // Away from zero if the error has the sum's sign, else towards it.
  const v128_t step = wasm_v128_or(wasm_i64x2_shr(wasm_v128_xor(sum, error), 63), one);
  return wasm_i64x2_add(sum, wasm_v128_and(step, wasm_v128_and(is_inexact, is_even)));
}

KNEAD_INLINE v128_t upper_as_doubles(v128_t a) { return wasm_f64x2_promote_low_f32x4(wasm_i64x2_shuffle(a, a, 1, 0)); }

// Where rounding a double to float is not the end of it: exactly between two floats, or below the normal ones.
KNEAD_INLINE v128_t is_doubtful_as_float(v128_t a) {
  const v128_t size = wasm_f64x2_abs(a);
  const v128_t is_between = wasm_i64x2_eq(wasm_v128_and(a, wasm_i64x2_splat(0x1fffffff)), wasm_i64x2_splat(0x10000000));
  const v128_t is_small =
      wasm_v128_and(wasm_f64x2_lt(size, wasm_f64x2_splat(0x1p-125)), wasm_f64x2_gt(size, wasm_f64x2_splat(0)));
  return wasm_v128_or(is_between, is_small);
}

// Products of floats are exact in double, and sums rounded to double round once more to the same float, but for the
// doubtful ones.
KNEAD_INLINE v128_t fused_floats(v128_t a, v128_t b, v128_t c) {
  const v128_t low = wasm_f64x2_mul(wasm_f64x2_promote_low_f32x4(a), wasm_f64x2_promote_low_f32x4(b));
  const v128_t high = wasm_f64x2_mul(upper_as_doubles(a), upper_as_doubles(b));
  const v128_t low_more = wasm_f64x2_promote_low_f32x4(c);
  const v128_t high_more = upper_as_doubles(c);
  v128_t low_sum = wasm_f64x2_add(low, low_more);
  v128_t high_sum = wasm_f64x2_add(high, high_more);
  if (__builtin_expect(wasm_v128_any_true(wasm_v128_or(is_doubtful_as_float(low_sum), is_doubtful_as_float(high_sum))),
                       0)) {
    low_sum = sum_to_odd(low, low_more);
    high_sum = sum_to_odd(high, high_more);
  }
  return wasm_i64x2_shuffle(wasm_f32x4_demote_f64x2_zero(low_sum), wasm_f32x4_demote_f64x2_zero(high_sum), 0, 2);
}

// The upper half of a number's digits (Veltkamp).
KNEAD_INLINE v128_t upper_digits(v128_t a) {
  const v128_t shifted = wasm_f64x2_mul(a, wasm_f64x2_splat(134217729.0));
  return wasm_f64x2_sub(shifted, wasm_f64x2_sub(shifted, a));
}

// What is wrong with a b as it was rounded (Dekker); exact within is_splittable.
KNEAD_INLINE v128_t product_error(v128_t a, v128_t b, v128_t product) {
  const v128_t ah = upper_digits(a);
  const v128_t bh = upper_digits(b);
  const v128_t al = wasm_f64x2_sub(a, ah);
  const v128_t bl = wasm_f64x2_sub(b, bh);
  v128_t error = wasm_f64x2_sub(wasm_f64x2_mul(ah, bh), product);
  error = wasm_f64x2_add(error, wasm_f64x2_mul(ah, bl));
  error = wasm_f64x2_add(error, wasm_f64x2_mul(al, bh));
  return wasm_f64x2_add(error, wasm_f64x2_mul(al, bl));
}

// Neither so large nor so small that halves of products overflow or lose digits.
KNEAD_INLINE v128_t is_splittable(v128_t a) {
  const v128_t size = wasm_f64x2_abs(a);
  return wasm_v128_and(wasm_f64x2_gt(size, wasm_f64x2_splat(0x1p-400)), wasm_f64x2_lt(size, wasm_f64x2_splat(0x1p400)));
}

KNEAD_INLINE v128_t fused_doubles(v128_t a, v128_t b, v128_t c) {
  const v128_t product = wasm_f64x2_mul(a, b);
  const v128_t zero = wasm_f64x2_splat(0);
  const v128_t has_zero = wasm_v128_or(wasm_f64x2_eq(a, zero), wasm_f64x2_eq(b, zero));
  const v128_t is_moderate = wasm_v128_and(wasm_v128_or(has_zero, wasm_v128_and(is_splittable(a), is_splittable(b))),
                                           wasm_f64x2_lt(wasm_f64x2_abs(c), wasm_f64x2_splat(0x1p900)));
  if (!wasm_i64x2_all_true(is_moderate)) {
    return wasm_f64x2_make(
        std::fma(wasm_f64x2_extract_lane(a, 0), wasm_f64x2_extract_lane(b, 0), wasm_f64x2_extract_lane(c, 0)),
        std::fma(wasm_f64x2_extract_lane(a, 1), wasm_f64x2_extract_lane(b, 1), wasm_f64x2_extract_lane(c, 1)));
  }
  const v128_t low = product_error(a, b, product);
  // c + low, then product + that: both as a sum and its error.
  const v128_t small = wasm_f64x2_add(c, low);
  const v128_t small_part = wasm_f64x2_sub(small, c);
  const v128_t small_error =
      wasm_f64x2_add(wasm_f64x2_sub(c, wasm_f64x2_sub(small, small_part)), wasm_f64x2_sub(low, small_part));
  const v128_t sum = wasm_f64x2_add(product, small);
  const v128_t sum_part = wasm_f64x2_sub(sum, product);
  const v128_t sum_error =
      wasm_f64x2_add(wasm_f64x2_sub(product, wasm_f64x2_sub(sum, sum_part)), wasm_f64x2_sub(small, sum_part));
  const v128_t result = wasm_f64x2_add(sum, sum_to_odd(small_error, sum_error));
  return wasm_v128_bitselect(wasm_f64x2_add(product, c), result, has_zero);  // also the sign of a zero
}

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

// The operations that fields are evaluated with (math/scalar.h).
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
      return Pack(fused_floats(a.v, b.v, c.v));
    } else {
      return Pack(fused_doubles(a.v, b.v, c.v));
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
