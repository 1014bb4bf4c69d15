#include "backend.h"

#include <fmt/format.h>

#include "knead/gpu/gpu.h"
#include "output.h"

namespace knead::command {

ChosenBackend choose_backend(const std::string& name, bool quiet) {
  if (name != "gpu") return {};
  const auto use = std::make_shared<BackendUse>();
  Backend gpu = gpu::backend_or_cpu([use, quiet](const std::string& why) {
    use->has_failed = true;
    if (!quiet) print_message(fmt::format("note: {}; the CPU moves the points instead", why));
  });
  Backend move = [use, gpu = std::move(gpu)](const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
    use->was_called = true;
    return gpu(flow, points, options);
  };
  return {std::move(move), use};
}

}  // namespace knead::command
