#include "flow/kernels/kernel_jacobian.h"
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable avx2_kernels() {
  using Float = Pack<float, xsimd::fma3<xsimd::avx2>>;
  using Double = Pack<double, xsimd::fma3<xsimd::avx2>>;
  return {"avx2", kernels_of<Float, Double>(), kernels_of<Double, Double>(), avx2_jacobian_kernels()};
}

JacobianKernels avx2_jacobian_kernels() { return jacobian_kernels_of<Pack<double, xsimd::fma3<xsimd::avx2>>>(); }

}  // namespace knead::detail
