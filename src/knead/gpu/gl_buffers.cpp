#include "knead/gpu/gl_buffers.h"

#include <fmt/format.h>

#include <algorithm>

#include "knead/gpu/gpu_error.h"

namespace knead::gpu {

void delete_buffer(GLuint name) { glDeleteBuffers(1, &name); }
void delete_program(GLuint name) { glDeleteProgram(name); }

namespace {

void delete_shader(GLuint name) { glDeleteShader(name); }

[[noreturn]] void fail(const char* step, std::string log) {
  log = log.substr(0, log.find_first_of(std::string("\n\0", 2)));
  throw GpuError(fmt::format("the graphics driver could not {} a shader ({}); use the cpu backend", step, log));
}

[[noreturn]] void fail_with(GLenum error) {
  throw GpuError(fmt::format("the graphics driver reports error {:#x}; use the cpu backend", error));
}

}  // namespace

Buffer make_buffer(const void* data, std::size_t bytes) {
  GLuint name = 0;
  glGenBuffers(1, &name);
  Buffer buffer(name);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, name);
  const std::size_t least = 16;  // an empty one cannot be bound
  glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(std::max(bytes, least)),
               bytes < least ? nullptr : data, GL_DYNAMIC_DRAW);
  if (bytes > 0 && bytes < least && data != nullptr) {
    glBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), data);
  }
  const GLenum error = glGetError();
  if (error == GL_OUT_OF_MEMORY) {
    throw GpuError(
        fmt::format("the GPU has too little memory left for {:.3g} MB more; close what else uses it, or use the cpu "
                    "backend",
                    1e-6 * static_cast<double>(bytes)));
  }
  if (error != GL_NO_ERROR) fail_with(error);
  return buffer;
}

void read_buffer(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, void* to) {
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(first_byte), static_cast<GLsizeiptr>(bytes), to);
}

void write_buffer(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, const void* from) {
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  glBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(first_byte), static_cast<GLsizeiptr>(bytes), from);
}

void copy_buffer(const Buffer& from, const Buffer& to, std::size_t bytes) {
  glBindBuffer(GL_COPY_READ_BUFFER, from.get());
  glBindBuffer(GL_COPY_WRITE_BUFFER, to.get());
  glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, static_cast<GLsizeiptr>(bytes));
}

void clear_words(const Buffer& buffer) {
  const GLuint zero = 0;
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  glClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
}

Program make_compute_program(const std::string& source) {
  const GlName<delete_shader> shader(glCreateShader(GL_COMPUTE_SHADER));
  const char* text = source.c_str();
  glShaderSource(shader.get(), 1, &text, nullptr);
  glCompileShader(shader.get());
  GLint done = GL_FALSE;
  std::string log(1024, '\0');
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &done);
  if (done != GL_TRUE) {
    glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
    fail("compile", log);
  }
  Program program(glCreateProgram());
  glAttachShader(program.get(), shader.get());
  glLinkProgram(program.get());
  glGetProgramiv(program.get(), GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return program;
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  fail("link", log);
}

void require_no_error() {
  const bool tells = epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_KHR_robustness");
  if (tells && glGetGraphicsResetStatus() != GL_NO_ERROR) {
    throw GpuError("the GPU was lost (its driver was reset); start again, or use the cpu backend");
  }
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  if (error == GL_OUT_OF_MEMORY) {
    throw GpuError("the GPU ran out of memory; close what else uses it, or use the cpu backend");
  }
  fail_with(error);
}

}  // namespace knead::gpu
