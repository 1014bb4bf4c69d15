// An OpenGL context of its own for computing. Internal to the gpu room.
#pragma once

#include <string>

namespace knead::gpu {

// A core context of OpenGL 4.3 without a window, through EGL: on a graphics card if there is one, else on the CPU
// (Mesa's llvmpipe). Current in no thread but while a CurrentContext is there.
class Context {
 public:
  Context();  // throws DeviceError where there is none
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const std::string& description() const { return description_; }
  bool is_software() const { return is_software_; }

 private:
  friend class CurrentContext;

  void* display_ = nullptr;
  void* context_ = nullptr;
  std::string description_;
  bool is_software_ = false;
};

// The context is current in this thread while this is there; then whichever was before it.
class CurrentContext {
 public:
  explicit CurrentContext(const Context& context);  // throws DeviceError where the driver refuses
  ~CurrentContext();
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

 private:
  void* display_ = nullptr;
  void* before_display_ = nullptr;
  void* before_context_ = nullptr;
  void* before_draw_ = nullptr;
  void* before_read_ = nullptr;
};

}  // namespace knead::gpu
