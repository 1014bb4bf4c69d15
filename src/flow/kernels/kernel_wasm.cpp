// The kernels for WebAssembly.
#include "flow/kernels/kernel_source.h"

namespace knead::detail {

KernelTable wasm_kernels() { return table_of<Pack<float>, Pack<double>>("wasm"); }

}  // namespace knead::detail
