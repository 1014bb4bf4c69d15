// Buffers that shaders read and write, for OpenGL with compute shaders.
#include <algorithm>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include "gl/objects.h"
#include "knead/editor/gl.h"

namespace knead::gl {

namespace {

// Two halves of a mapped buffer, through which the host copies large buffers: the GPU works on one half while the host
// works on the other. NVIDIA's own copies of large buffers are slower (docs/decisions/0013-gpu.md).
class Window {
 public:
  static constexpr std::size_t kHalf = std::size_t{8} << 20;

  Window(std::size_t bytes, bool reads) : half_(std::min(bytes, kHalf)) {
    const GLbitfield access =
        (reads ? GL_MAP_READ_BIT : GL_MAP_WRITE_BIT) | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    const auto size = static_cast<GLsizeiptr>(2 * half_);
    GLuint name = 0;
    glGenBuffers(1, &name);
    buffer_ = Buffer(name);
    glBindBuffer(GL_COPY_READ_BUFFER, name);
    glBufferStorage(GL_COPY_READ_BUFFER, size, nullptr, access | (reads ? GL_CLIENT_STORAGE_BIT : 0U));
    mapped_ = static_cast<std::byte*>(glMapBufferRange(GL_COPY_READ_BUFFER, 0, size, access));
    if (mapped_ == nullptr) {
      require_no_error();
      throw GpuError("the graphics driver shows the host no buffer; use the CPU");
    }
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  ~Window() {
    for (GLsync fence : fences_) glDeleteSync(fence);
  }

  const Buffer& buffer() const { return buffer_; }
  std::size_t half() const { return half_; }
  std::byte* part(std::size_t number) const { return mapped_ + number % 2 * half_; }

  // After a copy of the GPU: wait_for(number) returns when it and all before it are done.
  void mark(std::size_t number) {
    glDeleteSync(fences_[number % 2]);
    fences_[number % 2] = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  }
  void wait_for(std::size_t number) const {
    if (fences_[number % 2] == nullptr) return;
    GLenum state = GL_TIMEOUT_EXPIRED;
    while (state == GL_TIMEOUT_EXPIRED) {
      state = glClientWaitSync(fences_[number % 2], GL_SYNC_FLUSH_COMMANDS_BIT, 1'000'000'000);
    }
  }

 private:
  std::size_t half_;
  Buffer buffer_;
  std::byte* mapped_ = nullptr;
  GLsync fences_[2] = {};
};

constexpr std::size_t kMinWindowed = std::size_t{1} << 20;  // smaller copies are faster without a window

bool has_windows() { return epoxy_gl_version() >= 44 || epoxy_has_gl_extension("GL_ARB_buffer_storage"); }

// Whether the bound buffer can only be copied by the GPU.
bool needs_window() {
  GLint is_immutable = GL_FALSE;
  if (has_windows()) glGetBufferParameteriv(GL_SHADER_STORAGE_BUFFER, GL_BUFFER_IMMUTABLE_STORAGE, &is_immutable);
  return is_immutable != GL_FALSE;
}

void copy(const Buffer& from, std::size_t from_byte, const Buffer& to, std::size_t to_byte, std::size_t bytes) {
  glBindBuffer(GL_COPY_READ_BUFFER, from.get());
  glBindBuffer(GL_COPY_WRITE_BUFFER, to.get());
  glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(from_byte),
                      static_cast<GLintptr>(to_byte), static_cast<GLsizeiptr>(bytes));
}

}  // namespace

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
  if (bytes >= kMinWindowed && has_windows()) {
    glBufferStorage(GL_SHADER_STORAGE_BUFFER, size, nullptr, 0);
  } else {
    glBufferData(GL_SHADER_STORAGE_BUFFER, size, nullptr, GL_DYNAMIC_DRAW);
  }
  const GLenum error = glGetError();
  if (error == GL_OUT_OF_MEMORY) {
    throw GpuError(fmt::format(
        "the GPU has too little memory left for {:.3g} MB more; close other programs that use it, or use the CPU",
        1e-6 * static_cast<double>(bytes)));
  }
  if (error != GL_NO_ERROR) fail_with(error);
  if (data != nullptr) write_storage(buffer, 0, bytes, data);
  return buffer;
}

void read_storage(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, void* to) {
  if (bytes == 0) return;
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  if (!needs_window()) {
    glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(first_byte), static_cast<GLsizeiptr>(bytes), to);
    return;
  }
  Window window(bytes, true);
  const std::size_t parts = (bytes + window.half() - 1) / window.half();
  const auto size_of = [&](std::size_t k) { return std::min(window.half(), bytes - k * window.half()); };
  for (std::size_t k = 0; k <= parts; ++k) {
    if (k < parts) {
      copy(buffer, first_byte + k * window.half(), window.buffer(), k % 2 * window.half(), size_of(k));
      window.mark(k);
    }
    if (k == 0) continue;
    window.wait_for(k - 1);
    std::memcpy(static_cast<std::byte*>(to) + (k - 1) * window.half(), window.part(k - 1), size_of(k - 1));
  }
}

void write_storage(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, const void* from) {
  if (bytes == 0) return;
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  if (!needs_window()) {
    glBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(first_byte), static_cast<GLsizeiptr>(bytes), from);
    return;
  }
  Window window(bytes, false);
  for (std::size_t k = 0; k * window.half() < bytes; ++k) {
    const std::size_t size = std::min(window.half(), bytes - k * window.half());
    window.wait_for(k);
    std::memcpy(window.part(k), static_cast<const std::byte*>(from) + k * window.half(), size);
    copy(window.buffer(), k % 2 * window.half(), buffer, first_byte + k * window.half(), size);
    window.mark(k);
  }
}

void copy_storage(const Buffer& from, const Buffer& to, std::size_t bytes) { copy(from, 0, to, 0, bytes); }

void clear_storage(const Buffer& buffer) {
  const GLuint zero = 0;
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.get());
  glClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
}

void bind_storage(GLuint place, const Buffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, place, buffer.get());
}

}  // namespace knead::gl
