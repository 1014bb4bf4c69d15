#include "knead/flow/kernel_jacobian.h"

namespace knead::detail {

JacobianKernels neon_jacobian_kernels() { return jacobian_kernels_of<Pack<double, xsimd::neon64>>(); }

}  // namespace knead::detail
