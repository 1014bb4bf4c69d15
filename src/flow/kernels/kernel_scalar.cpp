#include "flow/kernels/kernel_jacobian.h"
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable scalar_kernels() {
  return {"scalar", kernels_of<ScalarPack<float>, ScalarPack<double>>(),
          kernels_of<ScalarPack<double>, ScalarPack<double>>(), scalar_jacobian_kernels()};
}

JacobianKernels scalar_jacobian_kernels() { return jacobian_kernels_of<ScalarPack<double>>(); }

}  // namespace knead::detail
