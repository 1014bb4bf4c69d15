// The kernels for machines without wide registers.
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable scalar_kernels() { return table_of<ScalarPack<float>, ScalarPack<double>>("scalar"); }

}  // namespace knead::detail
