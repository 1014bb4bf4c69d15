// Any bytes as a shape file of KNEAD_FUZZED_FORMAT: refused with InvalidInput, or a shape that keeps its promises
// (tests/support/shape_promises.h), in its own format and in every other.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "knead/error.h"
#include "knead/io.h"
#include "support/shape_promises.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::string broken =
        knead::broken_promise(knead::parse_shape(std::string(data, data + size), KNEAD_FUZZED_FORMAT, "fuzzed"));
    if (broken.empty()) return 0;
    std::fprintf(stderr, "broken promise: %s\n", broken.c_str());
    std::abort();
  } catch (const knead::InvalidInput&) {
    return 0;
  }
}
