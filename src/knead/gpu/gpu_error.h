// The failure of a GPU or of its driver.
#pragma once

#include <stdexcept>

namespace knead {

// Thrown where there is no GPU, its memory is too small, its driver refuses a request, or it was lost. One line: what
// is wrong; what to do.
class GpuError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace knead
