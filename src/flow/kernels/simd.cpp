// Chooses the kernels of this machine.
#include <cstdlib>
#include <string>
#include <vector>

#include "flow/kernels/kernel.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "math/system.h"

namespace knead {

namespace detail {
namespace {

// Returns the tables that this machine can run, the widest last.
std::vector<KernelTable> tables() {
  std::vector<KernelTable> result{scalar_kernels()};
#if defined(KNEAD_X86_KERNELS)
  if (has_avx2_and_fma()) result.push_back(avx2_kernels());
  if (has_avx512()) result.push_back(avx512_kernels());
#elif defined(KNEAD_NEON_KERNELS)
  result.push_back(neon_kernels());
#elif defined(KNEAD_WASM_KERNELS)
  result.push_back(wasm_kernels());
#endif
  return result;
}

}  // namespace

const KernelTable& kernels_in_use() {
  static const std::vector<KernelTable> all = tables();
  const char* const asked = std::getenv("KNEAD_SIMD");
  if (asked == nullptr || *asked == 0) return all.back();
  std::string names;
  for (const KernelTable& table : all) {
    if (std::string(table.name) == asked) return table;
    names += (names.empty() ? "" : ", ") + std::string(table.name);
  }
  throw InvalidInput("KNEAD_SIMD is " + std::string(asked) + ", which this machine does not have; use one of " + names);
}

}  // namespace detail

const char* simd_name() { return detail::kernels_in_use().name; }

}  // namespace knead
