#include "flow/kernels/kernel_jacobian.h"
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable scalar_kernels() {
  return {"scalar", kernels_of<Lane<float>, Lane<double>>(), kernels_of<Lane<double>, Lane<double>>(),
          scalar_jacobian_kernels()};
}

JacobianKernels scalar_jacobian_kernels() { return jacobian_kernels_of<Lane<double>>(); }

}  // namespace knead::detail
