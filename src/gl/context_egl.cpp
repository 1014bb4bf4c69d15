// Opens contexts through EGL, as on Linux.
#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <cstddef>
#include <vector>

#include "knead/editor/gl.h"

namespace knead::gl {

namespace {

bool client_supports(const char* extension) { return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension); }

// EGL's devices first: even where there is a GPU, Mesa's surfaceless platform may offer the CPU.
std::vector<EGLDisplay> candidate_displays() {
  std::vector<EGLDisplay> displays;
  if (!client_supports("EGL_EXT_platform_base")) return displays;
  if (client_supports("EGL_EXT_platform_device") &&
      (client_supports("EGL_EXT_device_enumeration") || client_supports("EGL_EXT_device_base"))) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_FALSE) count = 0;
    for (EGLint i = 0; i < count; ++i) {
      displays.push_back(
          eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)], nullptr));
    }
  }
  if (client_supports("EGL_MESA_platform_surfaceless")) {
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
  return displays;
}

// Returns the newest context that the display offers, which reports its loss where the driver can.
EGLContext create_context(EGLDisplay display, int least_version) {
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE ||
      eglBindAPI(EGL_OPENGL_API) == EGL_FALSE || !epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) {
    return EGL_NO_CONTEXT;
  }
  for (const int version : {43, 41, 33}) {
    if (version < least_version) break;
    const std::array<EGLint, 9> attributes{EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                           EGL_LOSE_CONTEXT_ON_RESET,
                                           EGL_CONTEXT_MAJOR_VERSION,
                                           version / 10,
                                           EGL_CONTEXT_MINOR_VERSION,
                                           version % 10,
                                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                           EGL_NONE};
    for (const std::size_t first : {0, 2}) {
      void* const context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data() + first);
      if (context != EGL_NO_CONTEXT) return context;
    }
  }
  return EGL_NO_CONTEXT;
}

}  // namespace

Context Context::open(int version) {
  // Without it epoxy ends the program.
  if (dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL) == nullptr) {
    throw GpuError("OpenGL cannot be used: libEGL.so.1 is not installed (Debian's package libegl1)");
  }
  Context best;
  for (EGLDisplay display : candidate_displays()) {
    Context found;
    found.display_ = display;
    found.context_ = create_context(display, version);
    if (found.context_ == EGL_NO_CONTEXT) continue;
    try {
      const CurrentContext current(found);
      found.describe_current();
    } catch (const GpuError&) {
      continue;
    }
    if (best.context_ == nullptr || !found.is_software_) best = std::move(found);
    if (!best.is_software_) break;
  }
  if (best.context_ == nullptr) {
    throw GpuError("no GPU with OpenGL " + std::to_string(version / 10) + "." + std::to_string(version % 10) +
                   " was found through EGL; install its driver, or Mesa's for the CPU");
  }
  return best;
}

// EGL displays are shared within a process, so only the context is ours to destroy.
Context::~Context() {
  if (context_ != nullptr) eglDestroyContext(display_, context_);
}

CurrentContext::CurrentContext(const Context& context)
    : is_adopted_(context.context_ == nullptr), display_(context.display_) {
  if (is_adopted_) return;
  before_display_ = eglGetCurrentDisplay();
  before_context_ = eglGetCurrentContext();
  before_draw_ = eglGetCurrentSurface(EGL_DRAW);
  before_read_ = eglGetCurrentSurface(EGL_READ);
  eglBindAPI(EGL_OPENGL_API);
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_) == EGL_FALSE) {
    throw GpuError("the GPU does not answer; start again, or use the CPU");
  }
}

CurrentContext::~CurrentContext() {
  if (is_adopted_) return;
  if (before_context_ == EGL_NO_CONTEXT) {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  } else {
    eglMakeCurrent(before_display_, before_draw_, before_read_, before_context_);
  }
}

}  // namespace knead::gl
