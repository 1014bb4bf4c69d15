#if defined(__GNUC__) && !defined(__clang__)
// g++ 12's own headers of AVX-512 read registers that they leave undefined on purpose.
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include "flow/kernels/kernel_jacobian.h"
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable avx512_kernels() {
  using Float = Pack<float, xsimd::avx512bw>;
  using Double = Pack<double, xsimd::avx512bw>;
  return {"avx512", kernels_of<Float, Double>(), kernels_of<Double, Double>(), avx512_jacobian_kernels()};
}

JacobianKernels avx512_jacobian_kernels() { return jacobian_kernels_of<Pack<double, xsimd::avx512bw>>(); }

}  // namespace knead::detail
