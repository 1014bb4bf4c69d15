// OpenGL contexts without a window, and the error of everything that runs on a GPU.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace knead {

// The failure of a GPU or of its driver: there is none, it has too little memory, it refuses a request, or it was lost.
// One line: what is wrong; what to do.
class GpuError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Versions of OpenGL are numbers such as 43 for OpenGL 4.3. Drawing needs 33, compute shaders need 43.
namespace gl {

// An OpenGL core context. It is current in a thread only while a CurrentContext of it exists there.
class Context {
 public:
  // Opens a new context through EGL, on a GPU if one is found, else on the CPU (Mesa's llvmpipe); on Windows through
  // WGL, with a window that is never shown, to be destroyed in the same thread. Throws GpuError if no driver offers
  // `version`.
  static Context open(int version);

  // Uses the context that is current in this thread. It must be current whenever this object is used. Throws GpuError
  // if there is none, or its version is lower.
  static Context adopt_current(int version);

  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  Context(Context&& other) noexcept { *this = std::move(other); }
  Context& operator=(Context&& other) noexcept;

  // The names of the GPU and of its driver.
  const std::string& description() const { return description_; }
  // True if the CPU does the work of a GPU.
  bool is_software() const { return is_software_; }

 private:
  friend class CurrentContext;
  Context() = default;
  void describe_current();

  void* display_ = nullptr;
  void* context_ = nullptr;  // null: the one that is current
  std::string description_;
  bool is_software_ = false;
};

// Makes a context current in this thread and restores the former one at the end. Leaves an adopted context as it is.
class CurrentContext {
 public:
  explicit CurrentContext(const Context& context);  // throws GpuError if the driver refuses
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

// A new context that is current in this thread while this object exists.
class OffscreenContext {
 public:
  explicit OffscreenContext(int version = 33) : context_(Context::open(version)), current_(context_) {}

  // Returns the names of the GPU and of its driver.
  const std::string& description() const { return context_.description(); }

 private:
  Context context_;
  CurrentContext current_;
};

// Throws GpuError if the current context has a lower version, or no context is current.
void require_version(int version);

// Returns true if the CPU does the work of a GPU in the current context.
bool is_software();

// Returns true if the driver can report that the current context was lost, e.g. because the GPU was reset.
bool reports_loss();

}  // namespace gl

}  // namespace knead
