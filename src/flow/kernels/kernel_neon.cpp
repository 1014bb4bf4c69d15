#include "flow/kernels/kernel_jacobian.h"
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable neon_kernels() {
  using Float = Pack<float, xsimd::neon64>;
  using Double = Pack<double, xsimd::neon64>;
  return {"neon", kernels_of<Float, Double>(), kernels_of<Double, Double>(), neon_jacobian_kernels()};
}

JacobianKernels neon_jacobian_kernels() { return jacobian_kernels_of<Pack<double, xsimd::neon64>>(); }

}  // namespace knead::detail
