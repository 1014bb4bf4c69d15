// The kernels for AVX2 and FMA.
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable avx2_kernels() {
  using Arch = xsimd::fma3<xsimd::avx2>;
  return table_of<Pack<float, Arch>, Pack<double, Arch>>("avx2");
}

}  // namespace knead::detail
