// What --backend chooses.
#pragma once

#include <memory>
#include <string>

#include "knead/flow/backend.h"

namespace knead::command {

// What became of a backend.
struct BackendUse {
  bool was_called = false;
  bool has_failed = false;  // the CPU did the rest
};

struct ChosenBackend {
  Backend move;  // empty: the CPU
  std::shared_ptr<const BackendUse> use{};

  // The report's "backend": gpu where the GPU moved the vertices, all of them.
  std::string name() const { return use != nullptr && use->was_called && !use->has_failed ? "gpu" : "cpu"; }
};

// Throws UsageError unless it is cpu, or gpu in a build that has that backend.
void check_backend(const std::string& name);

// Of a name that check_backend takes. Where there is no GPU, or it fails, a note on standard error says so unless
// quiet, and the CPU does the work.
ChosenBackend choose_backend(const std::string& name, bool quiet);

}  // namespace knead::command
