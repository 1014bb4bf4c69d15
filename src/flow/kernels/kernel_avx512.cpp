// The kernels for AVX-512.
#if defined(__GNUC__) && !defined(__clang__)
// g++ 12's own headers of AVX-512 read registers that they leave undefined on purpose.
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable avx512_kernels() {
  using Arch = xsimd::avx512bw;
  return table_of<Pack<float, Arch>, Pack<double, Arch>>("avx512");
}

}  // namespace knead::detail
