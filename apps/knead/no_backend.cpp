// The build without knead::gpu.
#include <fmt/format.h>

#include "backend.h"
#include "bench_gpu.h"
#include "command.h"

namespace knead::command {

void check_backend(const std::string& name) {
  if (name == "gpu") throw UsageError("this build has no GPU backend; leave --backend out");
  if (name != "cpu") throw UsageError(fmt::format("--backend {}: say cpu", name));
}

ChosenBackend choose_backend(const std::string& /*name*/, bool /*quiet*/) { return {}; }

Json measure_on_gpu(std::vector<BenchScene> /*scenes*/, bool /*all*/, bool /*quiet*/) { return {}; }

}  // namespace knead::command
