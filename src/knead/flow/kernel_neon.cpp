#include "knead/flow/kernel_source.h"

namespace knead::detail {

KernelTable neon_kernels() {
  using Float = Pack<float, xsimd::neon64>;
  using Double = Pack<double, xsimd::neon64>;
  return {"neon", kernels_of<Float, Double>(), kernels_of<Double, Double>(), neon_jacobian_kernels()};
}

}  // namespace knead::detail
