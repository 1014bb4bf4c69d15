// The context of a page: WebGL 2. The page makes it; nothing here opens another one.
#include <GLES3/gl3.h>
#include <emscripten/html5.h>

#include "knead/editor/gl.h"

namespace knead::gl {

namespace {

std::string text(GLenum name) {
  const GLubyte* found = glGetString(name);
  return found == nullptr ? std::string("unknown") : std::string(reinterpret_cast<const char*>(found));
}

// GL_RENDERER is "WebKit WebGL" everywhere in Chromium.
std::string renderer() {
  constexpr GLenum unmasked_renderer = 0x9246;
  const auto context = emscripten_webgl_get_current_context();
  const bool is_told = emscripten_webgl_enable_extension(context, "WEBGL_debug_renderer_info") != 0;
  return text(is_told ? unmasked_renderer : GL_RENDERER);
}

}  // namespace

void Context::describe_current() {
  is_software_ = gl::is_software();
  description_ = renderer() + ", " + text(GL_VERSION);
}

Context Context::open(int) { throw GpuError("a page cannot open OpenGL without a canvas; give it one"); }

Context Context::adopt_current(int version) {
  require_version(version);
  Context context;
  context.describe_current();
  return context;
}

Context::~Context() = default;

Context& Context::operator=(Context&& other) noexcept {
  std::swap(description_, other.description_);
  std::swap(is_software_, other.is_software_);
  return *this;
}

CurrentContext::CurrentContext(const Context&) : is_adopted_(true) {}
CurrentContext::~CurrentContext() = default;

// Everything that is drawn with OpenGL 3.3 needs only WebGL 2.
void require_version(int version) {
  if (version > 33) throw GpuError("WebGL has no compute shaders; use the CPU");
  if (glGetString(GL_VERSION) == nullptr) throw GpuError("the browser has no WebGL 2; use a newer one");
}

// Chromium's and Firefox's names.
bool is_software() {
  const std::string name = renderer();
  return name.find("SwiftShader") != std::string::npos || name.find("llvmpipe") != std::string::npos;
}

bool reports_loss() { return false; }

}  // namespace knead::gl
