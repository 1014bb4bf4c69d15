// Contexts of desktop OpenGL: the parts that do not depend on the system.
#include <epoxy/gl.h>

#include "knead/editor/gl.h"

namespace knead::gl {

namespace {

std::string text(GLenum name) {
  const GLubyte* found = glGetString(name);
  return found == nullptr ? std::string("unknown") : std::string(reinterpret_cast<const char*>(found));
}

std::string dotted(int version) { return std::to_string(version / 10) + "." + std::to_string(version % 10); }

}  // namespace

void Context::describe_current() {
  is_software_ = gl::is_software();
  description_ = text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

Context Context::adopt_current(int version) {
  require_version(version);
  Context context;
  context.describe_current();
  return context;
}

Context& Context::operator=(Context&& other) noexcept {
  std::swap(display_, other.display_);
  std::swap(context_, other.context_);
  std::swap(description_, other.description_);
  std::swap(is_software_, other.is_software_);
  return *this;
}

void require_version(int version) {
  if (glGetString(GL_VERSION) == nullptr || epoxy_gl_version() < version) {
    throw GpuError("the graphics driver has no OpenGL " + dotted(version) + "; install a newer driver");
  }
}

bool is_software() {
  const std::string renderer = text(GL_RENDERER);
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "SwiftShader", "SWR"}) {
    if (renderer.find(name) != std::string::npos) return true;
  }
  return false;
}

bool reports_loss() { return epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_KHR_robustness"); }

}  // namespace knead::gl
