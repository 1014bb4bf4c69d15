#include "knead/flow/kernel_jacobian.h"

namespace knead::detail {

JacobianKernels wasm_jacobian_kernels() { return jacobian_kernels_of<Pack<double>>(); }

}  // namespace knead::detail
