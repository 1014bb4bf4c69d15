#include "knead/flow/kernel_source.h"

namespace knead::detail {

KernelTable scalar_kernels() {
  return {"scalar", kernels_of<Lane<float>, Lane<double>>(), kernels_of<Lane<double>, Lane<double>>(),
          scalar_jacobian_kernels()};
}

}  // namespace knead::detail
