#include "knead/flow/kernel_source.h"

namespace knead::detail {

KernelTable wasm_kernels() {
  return {"wasm", kernels_of<Pack<float>, Pack<double>>(), kernels_of<Pack<double>, Pack<double>>(),
          wasm_jacobian_kernels()};
}

}  // namespace knead::detail
