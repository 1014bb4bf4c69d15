#include "flow/kernels/kernel_jacobian.h"
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable wasm_kernels() {
  return {"wasm", kernels_of<Pack<float>, Pack<double>>(), kernels_of<Pack<double>, Pack<double>>(),
          wasm_jacobian_kernels()};
}

JacobianKernels wasm_jacobian_kernels() { return jacobian_kernels_of<Pack<double>>(); }

}  // namespace knead::detail
