// Loaded into the command before its own libraries (LD_PRELOAD): makes its GPU fail, as KNEAD_TEST_LOSE_AT
// and KNEAD_TEST_STARVE say.
#include <cstdlib>
#include <string>

#include "support/provoked_failures.h"

namespace {

struct Failing {
  Failing() {
    if (const char* call = std::getenv("KNEAD_TEST_LOSE_AT")) knead::gpu::lose_display_at_call(std::stoi(call));
    if (const char* bytes = std::getenv("KNEAD_TEST_STARVE")) knead::gpu::starve_buffers(std::stoi(bytes));
  }
};

const Failing failing;

}  // namespace
