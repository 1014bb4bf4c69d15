// Measures the limits of the machine: multiply-adds and copies a second.
#include "yardsticks.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace knead::bench {

namespace {

constexpr int kRepeats = 400'000;
constexpr int kChains = 12;  // independent sums, to hide the latency of one

// Each body runs kRepeats rounds of kChains multiply-adds; returns a number that depends on all of them.
template <class T>
T plain_rounds() {
  T sums[kChains] = {};
  for (int i = 0; i < kRepeats; ++i) {
    for (T& sum : sums) sum = sum * T(0.999) + T(0.001);
  }
  T total = 0;
  for (const T sum : sums) total += sum;
  return total;
}

#if defined(__x86_64__)
__attribute__((target("avx512f"))) float rounds_512(float /*kind*/) {
  const __m512 a = _mm512_set1_ps(0.999F);
  const __m512 b = _mm512_set1_ps(0.001F);
  __m512 sums[kChains];
  for (__m512& sum : sums) sum = _mm512_setzero_ps();
  for (int i = 0; i < kRepeats; ++i) {
    for (__m512& sum : sums) sum = _mm512_fmadd_ps(sum, a, b);
  }
  float total = 0;
  for (const __m512& sum : sums) total += _mm512_cvtss_f32(sum);
  return total;
}

__attribute__((target("avx512f"))) double rounds_512(double /*kind*/) {
  const __m512d a = _mm512_set1_pd(0.999);
  const __m512d b = _mm512_set1_pd(0.001);
  __m512d sums[kChains];
  for (__m512d& sum : sums) sum = _mm512_setzero_pd();
  for (int i = 0; i < kRepeats; ++i) {
    for (__m512d& sum : sums) sum = _mm512_fmadd_pd(sum, a, b);
  }
  double total = 0;
  for (const __m512d& sum : sums) total += _mm512_cvtsd_f64(sum);
  return total;
}

__attribute__((target("avx2,fma"))) float rounds_256(float /*kind*/) {
  const __m256 a = _mm256_set1_ps(0.999F);
  const __m256 b = _mm256_set1_ps(0.001F);
  __m256 sums[kChains];
  for (__m256& sum : sums) sum = _mm256_setzero_ps();
  for (int i = 0; i < kRepeats; ++i) {
    for (__m256& sum : sums) sum = _mm256_fmadd_ps(sum, a, b);
  }
  float total = 0;
  for (const __m256& sum : sums) total += _mm256_cvtss_f32(sum);
  return total;
}

__attribute__((target("avx2,fma"))) double rounds_256(double /*kind*/) {
  const __m256d a = _mm256_set1_pd(0.999);
  const __m256d b = _mm256_set1_pd(0.001);
  __m256d sums[kChains];
  for (__m256d& sum : sums) sum = _mm256_setzero_pd();
  for (int i = 0; i < kRepeats; ++i) {
    for (__m256d& sum : sums) sum = _mm256_fmadd_pd(sum, a, b);
  }
  double total = 0;
  for (const __m256d& sum : sums) total += _mm256_cvtsd_f64(sum);
  return total;
}
#endif

// Multiply-adds in one run of the widest body that this machine has.
template <class T>
double run_widest() {
  volatile T keep = 0;  // so that the sums are needed
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) {
    keep = rounds_512(T(0));
    return double{kRepeats} * kChains * (64 / double{sizeof(T)});
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    keep = rounds_256(T(0));
    return double{kRepeats} * kChains * (32 / double{sizeof(T)});
  }
#endif
  keep = plain_rounds<T>();
  static_cast<void>(keep);
  return double{kRepeats} * kChains;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Returns the best of several short runs, because other work of the machine only slows them down.
template <class T>
double best_gflops(int threads) {
  constexpr int kRuns = 12;
  double best = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::thread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back([] { run_widest<T>(); });
    const double count = run_widest<T>();
    for (std::thread& other : others) other.join();
    best = std::max(best, 2e-9 * count * threads / seconds_since(start));
  }
  return best;
}

}  // namespace

double fma_gflops(Precision precision, int threads) {
  return precision == Precision::float32 ? best_gflops<float>(threads) : best_gflops<double>(threads);
}

double copy_gigabytes_per_second() {
  constexpr std::size_t kCount = 16 << 20;
  constexpr int kRuns = 5;
  const std::vector<double> from(kCount, 1.0);
  std::vector<double> to(kCount, 0.0);
  double best = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto start = std::chrono::steady_clock::now();
    std::copy(from.begin(), from.end(), to.begin());
    best = std::max(best, 2e-9 * static_cast<double>(kCount * sizeof(double)) / seconds_since(start));
  }
  return best;
}

}  // namespace knead::bench
