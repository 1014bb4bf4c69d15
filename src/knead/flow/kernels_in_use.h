// The kernels that this machine runs. Internal to the flow room.
#pragma once

#include "knead/flow/kernel.h"

namespace knead::detail {

// As simd_name says; asked for anew at every call, so that tests can compare them.
const KernelTable& kernels_in_use();

}  // namespace knead::detail
