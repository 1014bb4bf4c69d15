#include "knead/gpu/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "knead/gpu/gpu_error.h"

namespace knead::gpu {

namespace {

bool client_supports(const char* extension) { return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension); }

// Devices first: beside a GPU Mesa's surfaceless platform may offer the CPU.
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

// One that says when it is lost, where the driver can.
EGLContext create_context(EGLDisplay display) {
  if (eglInitialize(display, nullptr, nullptr) == EGL_FALSE || eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) {
    return EGL_NO_CONTEXT;
  }
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) return EGL_NO_CONTEXT;
  std::vector<EGLint> attributes{EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                 EGL_LOSE_CONTEXT_ON_RESET,
                                 EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 3,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
  void* const robust = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
  if (robust != EGL_NO_CONTEXT) return robust;
  return eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data() + 2);
}

std::string text(GLenum name) {
  const GLubyte* found = glGetString(name);
  return found == nullptr ? std::string("unknown") : std::string(reinterpret_cast<const char*>(found));
}

bool names_software(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "SwiftShader"}) {
    if (renderer.find(name) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

Context::Context(bool adopts_current) {
  if (adopts_current) {
    describe_current();
  } else {
    open();
  }
}

void Context::describe_current() {
  if (glGetString(GL_VERSION) == nullptr || epoxy_gl_version() < 43) {
    throw GpuError("the graphics driver has no OpenGL 4.3, which compute shaders need; use the cpu backend");
  }
  const std::string renderer = text(GL_RENDERER);
  is_software_ = names_software(renderer);
  description_ = fmt::format("{}, OpenGL {}", renderer, text(GL_VERSION));
}

void Context::open() {
  for (EGLDisplay display : candidate_displays()) {
    if (display == EGL_NO_DISPLAY) continue;
    void* const context = create_context(display);
    if (context == EGL_NO_CONTEXT) continue;
    std::string renderer;
    std::string version;
    std::swap(display_, display);
    void* const other = std::exchange(context_, context);
    try {
      const CurrentContext current(*this);
      renderer = text(GL_RENDERER);
      version = text(GL_VERSION);
    } catch (const GpuError&) {
      renderer.clear();
    }
    if (renderer.empty() || (other != nullptr && names_software(renderer))) {  // no better than what is there
      eglDestroyContext(display_, context);
      display_ = display;
      context_ = other;
      continue;
    }
    if (other != nullptr) eglDestroyContext(display, other);
    is_software_ = names_software(renderer);
    description_ = fmt::format("{}, OpenGL {}", renderer, version);
    if (!is_software_) return;
  }
  if (context_ == nullptr) {
    throw GpuError(
        "no GPU with OpenGL 4.3 compute shaders was found through EGL; install its driver (or Mesa, for "
        "the CPU), or use the cpu backend");
  }
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
    throw GpuError("the GPU does not answer; start again, or use the cpu backend");
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

}  // namespace knead::gpu
