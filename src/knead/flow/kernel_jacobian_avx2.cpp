#include "knead/flow/kernel_jacobian.h"

namespace knead::detail {

JacobianKernels avx2_jacobian_kernels() { return jacobian_kernels_of<Pack<double, xsimd::fma3<xsimd::avx2>>>(); }

}  // namespace knead::detail
