// An OpenGL context without a window.
#pragma once

#include <memory>
#include <string>

namespace knead::render {

// A core context (4.3 where there is one, at least 3.3) from EGL, current in the thread that made it until it is
// destroyed. Tries the surfaceless platform, then the devices. Throws std::runtime_error, one line, where neither gives
// a context.
class OffscreenContext {
 public:
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;
  OffscreenContext(OffscreenContext&&) noexcept;
  OffscreenContext& operator=(OffscreenContext&&) noexcept;

  // Driver and version, e.g. for a log.
  std::string description() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knead::render
