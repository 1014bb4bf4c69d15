// Whether tests can draw here. For tests only.
#pragma once

#include <cstdio>
#include <stdexcept>
#include <string>

#include "knead/gl/context.h"

namespace knead::render {

// The reason why there is no OpenGL here, or empty. Asked once: contexts are slow to make.
inline const std::string& no_context() {
  static const std::string reason = [] {
    try {
      std::printf("OpenGL: %s\n", gl::OffscreenContext().description().c_str());
      return std::string();
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
  }();
  return reason;
}

}  // namespace knead::render
