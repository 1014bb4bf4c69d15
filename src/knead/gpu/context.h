// An OpenGL context of its own for computing. Internal to the gpu room.
#pragma once

#include <string>

namespace knead::gpu {

// A core context of OpenGL 4.3 without a window, through EGL: on a GPU if there is one, else on the CPU
// (Mesa's llvmpipe). Current in no thread but while a CurrentContext is there.
class Context {
 public:
  // adopts_current: not one of its own but that which is current in this thread, and is whenever this is used. Throws
  // GpuError where there is none.
  explicit Context(bool adopts_current);
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const std::string& description() const { return description_; }
  bool is_software() const { return is_software_; }

 private:
  friend class CurrentContext;

  void open();
  void describe_current();

  void* display_ = nullptr;
  void* context_ = nullptr;  // null: the one that is current
  std::string description_;
  bool is_software_ = false;
};

// The context is current in this thread while this is there; then whichever was before it. Of an adopted one nothing
// changes.
class CurrentContext {
 public:
  explicit CurrentContext(const Context& context);  // throws GpuError where the driver refuses
  ~CurrentContext();
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

 private:
  bool is_adopted_ = false;
  void* display_ = nullptr;
  void* before_display_ = nullptr;
  void* before_context_ = nullptr;
  void* before_draw_ = nullptr;
  void* before_read_ = nullptr;
};

}  // namespace knead::gpu
