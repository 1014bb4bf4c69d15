// Packs in the registers of the processors that xsimd supports. Internal: pack.h includes it.
#pragma once

#include <xsimd/xsimd.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "knead/vec.h"

#define KNEAD_INLINE __attribute__((always_inline)) inline

namespace knead::detail {

// One bit per lane of a mask, the first lane's lowest.
template <class S, class Arch>
KNEAD_INLINE std::uint32_t bits_of(const xsimd::batch_bool<S, Arch>& mask) {
#if defined(__AVX512F__)
  return static_cast<std::uint32_t>(mask.data);
#elif defined(__AVX2__)
  if constexpr (sizeof(S) == 4) {
    return static_cast<std::uint32_t>(_mm256_movemask_ps(mask.data));
  } else {
    return static_cast<std::uint32_t>(_mm256_movemask_pd(mask.data));
  }
#elif defined(__aarch64__)
  if constexpr (sizeof(S) == 4) {
    return vaddvq_u32(vandq_u32(mask.data, uint32x4_t{1, 2, 4, 8}));
  } else {
    return static_cast<std::uint32_t>(vaddvq_u64(vandq_u64(mask.data, uint64x2_t{1, 2})));
  }
#else
  bool lanes[xsimd::batch_bool<S, Arch>::size];
  mask.store_unaligned(lanes);
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < xsimd::batch_bool<S, Arch>::size; ++i) bits |= std::uint32_t{lanes[i]} << i;
  return bits;
#endif
}

// Rounded once. xsimd 8.1 rounds twice, by a product and a sum, for AVX-512 and in part for NEON.
template <class Batch>
KNEAD_INLINE Batch fused(const Batch& a, const Batch& b, const Batch& c) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) {
    return _mm512_fmadd_ps(a, b, c);
  } else {
    return _mm512_fmadd_pd(a, b, c);
  }
#elif defined(__aarch64__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) {
    return vfmaq_f32(c, a, b);
  } else {
    return vfmaq_f64(c, a, b);
  }
#else
  return xsimd::fma(a, b, c);
#endif
}

template <class Batch>
KNEAD_INLINE Batch fused_sub(const Batch& a, const Batch& b, const Batch& c) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) {
    return _mm512_fmsub_ps(a, b, c);
  } else {
    return _mm512_fmsub_pd(a, b, c);
  }
#elif defined(__aarch64__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) {
    return vfmaq_f32(vnegq_f32(c), a, b);
  } else {
    return vfmaq_f64(vnegq_f64(c), a, b);
  }
#else
  return xsimd::fms(a, b, c);
#endif
}

template <class Batch>
KNEAD_INLINE Batch neg_fused(const Batch& a, const Batch& b, const Batch& c) {
#if defined(__AVX512F__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) {
    return _mm512_fnmadd_ps(a, b, c);
  } else {
    return _mm512_fnmadd_pd(a, b, c);
  }
#elif defined(__aarch64__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) {
    return vfmsq_f32(c, a, b);
  } else {
    return vfmsq_f64(c, a, b);
  }
#else
  return xsimd::fnma(a, b, c);
#endif
}

// Rounded correctly. xsimd 8.1 approximates division and square root for NEON's float.
template <class Batch>
KNEAD_INLINE Batch divided(const Batch& a, const Batch& b) {
#if defined(__aarch64__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) return vdivq_f32(a, b);
#endif
  return a / b;
}

template <class Batch>
KNEAD_INLINE Batch square_root(const Batch& a) {
#if defined(__aarch64__)
  if constexpr (std::is_same_v<typename Batch::value_type, float>) return vsqrtq_f32(a);
#endif
  return xsimd::sqrt(a);
}

// Reads the words at `count` offsets in bytes.
template <std::size_t count>
KNEAD_INLINE void gather_words(const std::uint8_t* from, const std::int32_t* offset, std::uint32_t* to) {
#if defined(__AVX2__)
  const int* const base = reinterpret_cast<const int*>(from);
#if defined(__AVX512F__)
  if constexpr (count == 16) {
    _mm512_storeu_si512(to, _mm512_i32gather_epi32(_mm512_loadu_si512(offset), from, 1));
    return;
  }
#endif
  if constexpr (count == 8) {
    const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(offset));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_i32gather_epi32(base, at, 1));
  } else if constexpr (count == 4) {
    const __m128i at = _mm_loadu_si128(reinterpret_cast<const __m128i*>(offset));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_i32gather_epi32(base, at, 1));
  }
#else
  for (std::size_t k = 0; k < count; ++k) std::memcpy(to + k, from + offset[k], 4);
#endif
}

// Converts the bytes of words from a bit on.
template <std::size_t count, class S>
KNEAD_INLINE void bytes_as_numbers(const std::uint32_t* words, int bit, S* to) {
#if defined(__AVX2__)
#if defined(__AVX512F__)
  if constexpr (count == 16) {
    const __m512i bytes = _mm512_and_si512(_mm512_srli_epi32(_mm512_loadu_si512(words), static_cast<unsigned>(bit)),
                                           _mm512_set1_epi32(255));
    _mm512_storeu_ps(to, _mm512_cvtepi32_ps(bytes));
    return;
  }
  if constexpr (count == 8 && sizeof(S) == 8) {
    const __m256i loaded = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(words));
    const __m256i bytes = _mm256_and_si256(_mm256_srli_epi32(loaded, bit), _mm256_set1_epi32(255));
    _mm512_storeu_pd(to, _mm512_cvtepi32_pd(bytes));
    return;
  }
#endif
  if constexpr (count == 8 && sizeof(S) == 4) {
    const __m256i loaded = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(words));
    const __m256i bytes = _mm256_and_si256(_mm256_srli_epi32(loaded, bit), _mm256_set1_epi32(255));
    _mm256_storeu_ps(to, _mm256_cvtepi32_ps(bytes));
  } else if constexpr (count == 4) {
    const __m128i loaded = _mm_loadu_si128(reinterpret_cast<const __m128i*>(words));
    const __m128i bytes = _mm_and_si128(_mm_srli_epi32(loaded, bit), _mm_set1_epi32(255));
    _mm256_storeu_pd(to, _mm256_cvtepi32_pd(bytes));
  }
#else
  for (std::size_t k = 0; k < count; ++k) to[k] = static_cast<S>(words[k] >> bit & 255U);
#endif
}

template <class S, class Arch>
struct PackMask {
  xsimd::batch_bool<S, Arch> v;

  KNEAD_INLINE friend PackMask operator&(const PackMask& a, const PackMask& b) { return {a.v & b.v}; }
  KNEAD_INLINE friend PackMask operator|(const PackMask& a, const PackMask& b) { return {a.v | b.v}; }
  KNEAD_INLINE friend PackMask operator!(const PackMask& a) { return {!a.v}; }
  KNEAD_INLINE friend std::uint32_t bits(const PackMask& a) { return bits_of(a.v); }
};

// The operations that the evaluation of fields needs (knead/vec.h). Arch: an architecture of xsimd.
template <class S, class Arch>
struct Pack {
  using Scalar = S;
  using Mask = PackMask<S, Arch>;
  using Batch = xsimd::batch<S, Arch>;
  static constexpr std::size_t kSize = Batch::size;

  Batch v;

  KNEAD_INLINE Pack() : v(S(0)) {}
  KNEAD_INLINE explicit Pack(S value) : v(value) {}
  template <class U>
  requires std::is_arithmetic_v<U> KNEAD_INLINE explicit Pack(U value) : v(static_cast<S>(value)) {}
  KNEAD_INLINE explicit Pack(const Batch& batch) : v(batch) {}

  KNEAD_INLINE static Pack load(const S* from) { return Pack(Batch::load_unaligned(from)); }
  KNEAD_INLINE void store(S* to) const { v.store_unaligned(to); }

  // Reads the four bytes at each offset, as words.
  KNEAD_INLINE static void gather(const std::uint8_t* from, const std::int32_t (&offset)[kSize],
                                  std::uint32_t (&to)[kSize]) {
    gather_words<kSize>(from, offset, to);
  }

  // Returns the bytes of this index, 0: the lowest, of words.
  KNEAD_INLINE static Pack from_bytes(const std::uint32_t (&words)[kSize], int index) {
    S numbers[kSize];
    bytes_as_numbers<kSize>(words, 8 * index, numbers);
    return load(numbers);
  }

  KNEAD_INLINE friend Pack operator+(const Pack& a, const Pack& b) { return Pack(a.v + b.v); }
  KNEAD_INLINE friend Pack operator-(const Pack& a, const Pack& b) { return Pack(a.v - b.v); }
  KNEAD_INLINE friend Pack operator*(const Pack& a, const Pack& b) { return Pack(a.v * b.v); }
  KNEAD_INLINE friend Pack operator/(const Pack& a, const Pack& b) { return Pack(divided(a.v, b.v)); }
  KNEAD_INLINE friend Pack operator-(const Pack& a) { return Pack(Batch(S(-0.0)) - a.v); }
  KNEAD_INLINE friend Mask operator<(const Pack& a, const Pack& b) { return {a.v < b.v}; }
  KNEAD_INLINE friend Mask operator>(const Pack& a, const Pack& b) { return {a.v > b.v}; }
  KNEAD_INLINE friend Mask operator<=(const Pack& a, const Pack& b) { return {a.v <= b.v}; }
  KNEAD_INLINE friend Mask operator>=(const Pack& a, const Pack& b) { return {a.v >= b.v}; }
  KNEAD_INLINE friend Mask operator==(const Pack& a, const Pack& b) { return {a.v == b.v}; }

  KNEAD_INLINE friend Pack select(const Mask& mask, const Pack& a, const Pack& b) {
    return Pack(xsimd::select(mask.v, a.v, b.v));
  }
  KNEAD_INLINE friend Pack sqrt(const Pack& a) { return Pack(square_root(a.v)); }
  KNEAD_INLINE friend Pack mul_add(const Pack& a, const Pack& b, const Pack& c) { return Pack(fused(a.v, b.v, c.v)); }
  KNEAD_INLINE friend Pack mul_sub(const Pack& a, const Pack& b, const Pack& c) {
    return Pack(fused_sub(a.v, b.v, c.v));
  }
  KNEAD_INLINE friend Pack neg_mul_add(const Pack& a, const Pack& b, const Pack& c) {
    return Pack(neg_fused(a.v, b.v, c.v));
  }
#if defined(__x86_64__)
  // With NaN, those of x86 return the second operand, those of knead/vec.h the first.
  KNEAD_INLINE friend Pack minimum(const Pack& a, const Pack& b) { return Pack(xsimd::min(b.v, a.v)); }
  KNEAD_INLINE friend Pack maximum(const Pack& a, const Pack& b) { return Pack(xsimd::max(b.v, a.v)); }
#endif
  KNEAD_INLINE friend Pack round_to_integer(const Pack& a) {
    const Pack shift(kSinglePrecision<S> ? S(12582912.0) : S(6755399441055744.0));
    return (a + shift) - shift;
  }
};

#if defined(__AVX512F__)
// Stores the lanes whose bits are set contiguously, followed by others, a pack in all. Returns the number of set bits.
// Other instruction sets have no instruction for it.
template <class S, class Arch>
KNEAD_INLINE std::size_t store_lanes(const Pack<S, Arch>& a, std::uint32_t lanes, S* to) {
  if constexpr (sizeof(S) == 4) {
    _mm512_storeu_ps(to, _mm512_maskz_compress_ps(static_cast<__mmask16>(lanes), a.v));
  } else {
    _mm512_storeu_pd(to, _mm512_maskz_compress_pd(static_cast<__mmask8>(lanes), a.v));
  }
  return static_cast<std::size_t>(__builtin_popcount(lanes));
}
#endif

}  // namespace knead::detail

namespace knead {

template <class Arch>
inline constexpr bool kSinglePrecision<detail::Pack<float, Arch>> = true;

}  // namespace knead
