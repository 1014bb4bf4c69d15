// Makes buffers, textures, framebuffers and programs, and reports OpenGL's errors.
#include "gl/objects.h"

#include <vector>

#include <fmt/format.h>

#include "knead/editor/gl.h"
#include "knead/error.h"

namespace knead::gl {

void delete_buffer(GLuint name) { glDeleteBuffers(1, &name); }
void delete_vertex_array(GLuint name) { glDeleteVertexArrays(1, &name); }
void delete_texture(GLuint name) { glDeleteTextures(1, &name); }
void delete_framebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
void delete_renderbuffer(GLuint name) { glDeleteRenderbuffers(1, &name); }
void delete_program(GLuint name) { glDeleteProgram(name); }

void fail_with(GLenum error) {
  throw GpuError(fmt::format("the graphics driver reports error {:#x}; update it, or use the CPU", error));
}

Buffer make_buffer(GLenum target, const void* data, std::size_t bytes) {
  GLuint name = 0;
  glGenBuffers(1, &name);
  glBindBuffer(target, name);
  glBufferData(target, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
  return Buffer(name);
}

VertexArray make_vertex_array() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  glBindVertexArray(name);
  return VertexArray(name);
}

namespace {

struct PixelFormat {
  GLenum format;
  GLenum type;
};

// The format that glTexImage requires even without data.
PixelFormat pixel_format(GLenum internal_format) {
  if (internal_format == GL_DEPTH_COMPONENT32F) return {GL_DEPTH_COMPONENT, GL_FLOAT};
  if (internal_format == GL_RGBA8) return {GL_RGBA, GL_UNSIGNED_BYTE};
  if (internal_format == GL_RGB32F) return {GL_RGB, GL_FLOAT};
  if (internal_format == GL_R32UI) return {GL_RED_INTEGER, GL_UNSIGNED_INT};
  return {GL_RGBA, GL_FLOAT};
}

void set_filter(GLenum target, GLenum filter, GLenum wrap) {
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(filter));
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  glTexParameteri(target, GL_TEXTURE_WRAP_S, static_cast<GLint>(wrap));
  glTexParameteri(target, GL_TEXTURE_WRAP_T, static_cast<GLint>(wrap));
  glTexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
}

void require_memory() {
  if (glGetError() == GL_OUT_OF_MEMORY) {
    throw InvalidInput("not enough graphics memory for a picture of this size; make it smaller");
  }
}

void delete_shader(GLuint name) { glDeleteShader(name); }
using Shader = Name<delete_shader>;

// Returns the line of a driver's log with the reason: the first with "error", because NVIDIA's begins with a heading.
std::string reason_in(const std::string& log) {
  const std::string_view text = std::string_view(log).substr(0, log.find('\0'));
  const std::size_t error = text.find("error");
  const std::size_t at = error == std::string_view::npos ? 0 : error;
  const std::size_t before = text.rfind('\n', at);
  const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
  return std::string(text.substr(begin, text.find('\n', begin) - begin));
}

[[noreturn]] void fail(const char* step, const std::string& log) {
  const std::string reason = reason_in(log);
  throw GpuError(
      fmt::format("the graphics driver could not {} a shader ({}); update it, or use the CPU", step, reason));
}

Shader make_shader(GLenum kind, const std::string& source) {
  Shader shader(glCreateShader(kind));
  const char* text = source.c_str();
  glShaderSource(shader.get(), 1, &text, nullptr);
  glCompileShader(shader.get());
  GLint done = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  std::string log(1024, '\0');
  glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  fail("compile", log);
}

Program link(std::initializer_list<const Shader*> shaders) {
  Program program(glCreateProgram());
  for (const Shader* shader : shaders) glAttachShader(program.get(), shader->get());
  glLinkProgram(program.get());
  GLint done = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return program;
  std::string log(1024, '\0');
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  fail("link", log);
}

}  // namespace

Texture make_texture(int width, int height, GLenum internal_format) {
  GLuint name = 0;
  glGenTextures(1, &name);
  Texture texture(name);
  glBindTexture(GL_TEXTURE_2D, name);
  set_filter(GL_TEXTURE_2D, GL_NEAREST, GL_CLAMP_TO_EDGE);
  const PixelFormat given = pixel_format(internal_format);
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal_format), width, height, 0, given.format, given.type,
               nullptr);
  require_memory();
  return texture;
}

Framebuffer make_framebuffer(std::initializer_list<const Texture*> colors, const Texture* depth) {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  Framebuffer framebuffer(name);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  std::vector<GLenum> targets;
  for (const Texture* color : colors) {
    targets.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(targets.size()));
    attach(targets.back(), color->get());
  }
  if (depth != nullptr) attach(GL_DEPTH_ATTACHMENT, depth->get());
  glDrawBuffers(static_cast<GLsizei>(targets.size()), targets.data());
  return framebuffer;
}

Program make_program(const std::string& vertex, const std::string& fragment) {
  const Shader first = make_shader(GL_VERTEX_SHADER, vertex);
  const Shader second = make_shader(GL_FRAGMENT_SHADER, fragment);
  return link({&first, &second});
}

#if !defined(__EMSCRIPTEN__)
Program make_compute_program(const std::string& source) {
  const Shader shader = make_shader(GL_COMPUTE_SHADER, source);
  return link({&shader});
}
#endif

GLint uniform(const Program& program, const char* name) { return glGetUniformLocation(program.get(), name); }

void bind_texture(const Program& program, const char* name, int unit, GLenum target, const Texture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture.get());
  glUniform1i(uniform(program, name), unit);
}

void require_no_error() {
  if (reports_loss() && was_reset()) {
    throw GpuError("the GPU was lost (its driver was reset); start again, or use the CPU");
  }
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  if (error == GL_OUT_OF_MEMORY) {
    throw GpuError("the GPU ran out of memory; close other programs that use it, or use the CPU");
  }
  fail_with(error);
}

}  // namespace knead::gl
