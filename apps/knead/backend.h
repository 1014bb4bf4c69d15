// What --backend chooses.
#pragma once

#include <memory>
#include <string>

#include "knead/flow/backend.h"

namespace knead::command {

// What happened to a backend.
struct BackendUse {
  bool was_called = false;
  bool has_failed = false;  // the CPU did the rest
};

struct ChosenBackend {
  Backend move;  // empty: the CPU
  std::shared_ptr<const BackendUse> use{};

  // Returns the report's "backend": gpu only if the GPU moved all vertices.
  std::string name() const { return use != nullptr && use->was_called && !use->has_failed ? "gpu" : "cpu"; }
};

// Returns the backend of a name that check_backend accepts. If there is no GPU, or it fails, the CPU does the work, and
// a note on standard error says so unless quiet.
ChosenBackend choose_backend(const std::string& name, bool quiet);

}  // namespace knead::command
