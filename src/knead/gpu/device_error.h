// What goes wrong with a graphics card.
#pragma once

#include <stdexcept>

namespace knead::gpu {

// There is none, its memory is too small, or it was lost. One line: what is wrong; what to do. The points are as they
// were.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace knead::gpu
