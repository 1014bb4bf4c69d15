// The kernels for NEON of 64-bit ARM.
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable neon_kernels() {
  using Arch = xsimd::neon64;
  return table_of<Pack<float, Arch>, Pack<double, Arch>>("neon");
}

}  // namespace knead::detail
