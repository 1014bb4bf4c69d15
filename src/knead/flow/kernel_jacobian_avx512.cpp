#if defined(__GNUC__) && !defined(__clang__)
// g++ 12's own headers of AVX-512 read registers that they leave undefined on purpose.
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include "knead/flow/kernel_jacobian.h"

namespace knead::detail {

JacobianKernels avx512_jacobian_kernels() { return jacobian_kernels_of<Pack<double, xsimd::avx512bw>>(); }

}  // namespace knead::detail
