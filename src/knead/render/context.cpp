#include "knead/render/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <stdexcept>
#include <utility>
#include <vector>

namespace knead::render {

struct OffscreenContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  // EGL displays are shared within a process, so only the context is ours to destroy.
  ~State() {
    if (context == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
    eglReleaseThread();
  }
};

namespace {

bool client_supports(const char* extension) { return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension); }

std::vector<EGLDisplay> candidate_displays() {
  std::vector<EGLDisplay> displays;
  if (!client_supports("EGL_EXT_platform_base")) return displays;
  if (client_supports("EGL_MESA_platform_surfaceless")) {
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
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
  return displays;
}

EGLContext create_context(EGLDisplay display, int major, int minor) {
  const std::array<EGLint, 7> attributes{
      EGL_CONTEXT_MAJOR_VERSION,           major,   EGL_CONTEXT_MINOR_VERSION, minor, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  return eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
}

bool make_current(EGLDisplay display, EGLContext& context) {
  if (eglInitialize(display, nullptr, nullptr) == EGL_FALSE || eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return false;
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) return false;
  for (const auto& [major, minor] : {std::pair{4, 3}, std::pair{4, 1}, std::pair{3, 3}}) {
    context = create_context(display, major, minor);
    if (context == EGL_NO_CONTEXT) continue;
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE) return true;
    eglDestroyContext(display, context);
    context = EGL_NO_CONTEXT;
  }
  return false;
}

}  // namespace

OffscreenContext::OffscreenContext() : state_(std::make_unique<State>()) {
  for (EGLDisplay display : candidate_displays()) {
    if (display == EGL_NO_DISPLAY || !make_current(display, state_->context)) continue;
    state_->display = display;
    return;
  }
  throw std::runtime_error(
      "render: no OpenGL 3.3 through EGL (tried the surfaceless platform and all devices); install a driver, e.g. "
      "Mesa");
}

OffscreenContext::~OffscreenContext() = default;
OffscreenContext::OffscreenContext(OffscreenContext&&) noexcept = default;
OffscreenContext& OffscreenContext::operator=(OffscreenContext&&) noexcept = default;

std::string OffscreenContext::description() const {
  const auto text = [](GLenum name) { return std::string(reinterpret_cast<const char*>(glGetString(name))); };
  return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

}  // namespace knead::render
