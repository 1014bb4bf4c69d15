// Fused multiply-adds of WebAssembly, composed of its other operations, with the bits of other machines.
#include <emscripten.h>
#include <wasm_simd128.h>

#include <cmath>

#include "flow/kernels/pack_wasm.h"

namespace knead::detail {
namespace {

// a + b in double, rounded to odd: rounding this once more, to fewer digits, gives the sum's own rounding (Boldo and
// Melquiond, Emulation of FMA and correctly rounded sums, 2008).
inline v128_t sum_to_odd(v128_t a, v128_t b) {
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

inline v128_t upper_as_doubles(v128_t a) { return wasm_f64x2_promote_low_f32x4(wasm_i64x2_shuffle(a, a, 1, 0)); }

// Doubles whose rounding to float is doubtful: exactly between two floats, or below the normal ones.
inline v128_t is_doubtful_as_float(v128_t a) {
  const v128_t size = wasm_f64x2_abs(a);
  const v128_t is_between = wasm_i64x2_eq(wasm_v128_and(a, wasm_i64x2_splat(0x1fffffff)), wasm_i64x2_splat(0x10000000));
  const v128_t is_small =
      wasm_v128_and(wasm_f64x2_lt(size, wasm_f64x2_splat(0x1p-125)), wasm_f64x2_gt(size, wasm_f64x2_splat(0)));
  return wasm_v128_or(is_between, is_small);
}

// The upper half of a number's digits (Veltkamp).
inline v128_t upper_digits(v128_t a) {
  const v128_t shifted = wasm_f64x2_mul(a, wasm_f64x2_splat(134217729.0));
  return wasm_f64x2_sub(shifted, wasm_f64x2_sub(shifted, a));
}

// The rounding error of the product a b (Dekker); exact within is_splittable.
inline v128_t product_error(v128_t a, v128_t b, v128_t product) {
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
inline v128_t is_splittable(v128_t a) {
  const v128_t size = wasm_f64x2_abs(a);
  return wasm_v128_and(wasm_f64x2_gt(size, wasm_f64x2_splat(0x1p-400)), wasm_f64x2_lt(size, wasm_f64x2_splat(0x1p400)));
}

}  // namespace
}  // namespace knead::detail

using namespace knead::detail;

// Both are exported so that bindings/web/list_fused.mjs finds their calls.
extern "C" {

// Products of floats are exact in double, and sums rounded to double round to the same float, except doubtful ones.
EMSCRIPTEN_KEEPALIVE v128_t knead_fused_floats(v128_t a, v128_t b, v128_t c) noexcept {
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

EMSCRIPTEN_KEEPALIVE v128_t knead_fused_doubles(v128_t a, v128_t b, v128_t c) noexcept {
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

}  // extern "C"
