// Buffers that shaders read and write: where OpenGL has compute shaders.
#include <algorithm>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "gl/objects.h"
#include "knead/gl.h"

namespace knead::gl {

Buffer make_storage(const void* data, std::size_t bytes) {
  constexpr std::size_t least = 16;  // an empty buffer cannot be bound
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (bytes > static_cast<std::uint64_t>(most)) {
    throw GpuError(fmt::format("the graphics driver allows no buffer of {:.3g} MB; use a smaller shape, or the CPU",
                               1e-6 * static_cast<double>(bytes)));
  }
  GLuint name = 0;
  glGenBuffers(1, &name);
  Buffer buffer(name);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, name);
  const auto size = static_cast<GLsizeiptr>(std::max(bytes, least));
  const void* const from = bytes < least ? nullptr : data;
  // With NVIDIA's driver, shaders read large buffers from glBufferStorage faster (docs/performance.md).
  const std::string_view vendor = reinterpret_cast<const char*>(glGetString(GL_VENDOR));
  if (vendor.starts_with("NVIDIA") && (epoxy_gl_version() >= 44 || epoxy_has_gl_extension("GL_ARB_buffer_storage"))) {
    glBufferStorage(GL_SHADER_STORAGE_BUFFER, size, from, GL_DYNAMIC_STORAGE_BIT);
  } else {
    glBufferData(GL_SHADER_STORAGE_BUFFER, size, from, GL_DYNAMIC_DRAW);
  }
  if (bytes < least && data != nullptr) write_storage(buffer, 0, bytes, data);
  const GLenum error = glGetError();
  if (error == GL_OUT_OF_MEMORY) {
    throw GpuError(fmt::format(
        "the GPU has too little memory left for {:.3g} MB more; close other programs that use it, or use the CPU",
        1e-6 * static_cast<double>(bytes)));
  }
  if (error != GL_NO_ERROR) fail_with(error);
  return buffer;
}

void read_storage(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, void* to) {
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(first_byte), static_cast<GLsizeiptr>(bytes), to);
}

void write_storage(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, const void* from) {
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  glBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(first_byte), static_cast<GLsizeiptr>(bytes), from);
}

void copy_storage(const Buffer& from, const Buffer& to, std::size_t bytes) {
  glBindBuffer(GL_COPY_READ_BUFFER, from.get());
  glBindBuffer(GL_COPY_WRITE_BUFFER, to.get());
  glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, static_cast<GLsizeiptr>(bytes));
}

void clear_storage(const Buffer& buffer) {
  const GLuint zero = 0;
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  glClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
}

void bind_storage(GLuint place, const Buffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, place, buffer.get());
}

}  // namespace knead::gl
