#include "knead/flow/kernel_jacobian.h"

namespace knead::detail {

JacobianKernels scalar_jacobian_kernels() { return jacobian_kernels_of<Lane<double>>(); }

}  // namespace knead::detail
