// OpenGL of the system, or of a page (WebGL 2, which is OpenGL ES 3.0), and owners of its objects. Drawing on pages
// uses only functions that both have; the functions below hide their differences. Internal to gpu and render.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>

#if defined(__EMSCRIPTEN__)
#include <GLES3/gl3.h>
#else
#include <epoxy/gl.h>
#endif

namespace knead::gl {

#if defined(__EMSCRIPTEN__)

// Shaders clip, and points always have the size that a shader sets.
inline void set_clipping(bool) {}
inline void let_shaders_size_points() {}
inline void write_colors_as_they_are() {}
inline void clear_depth_to(float depth) { glClearDepthf(depth); }
inline void attach(GLenum place, GLuint texture) {
  glFramebufferTexture2D(GL_FRAMEBUFFER, place, GL_TEXTURE_2D, texture, 0);
}
inline bool was_reset() { return false; }

#else

inline void set_clipping(bool on) { on ? glEnable(GL_CLIP_DISTANCE0) : glDisable(GL_CLIP_DISTANCE0); }
inline void let_shaders_size_points() { glEnable(GL_PROGRAM_POINT_SIZE); }
inline void write_colors_as_they_are() { glDisable(GL_FRAMEBUFFER_SRGB); }
inline void clear_depth_to(float depth) { glClearDepth(depth); }
inline void attach(GLenum place, GLuint texture) { glFramebufferTexture(GL_FRAMEBUFFER, place, texture, 0); }
inline bool was_reset() { return glGetGraphicsResetStatus() != GL_NO_ERROR; }

#endif

// Draw into the first colour of the bound framebuffer; into the first two.
inline void draw_into_one() {
  const GLenum first = GL_COLOR_ATTACHMENT0;
  glDrawBuffers(1, &first);
}
inline void draw_into_two() {
  const GLenum both[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(2, both);
}

// Move-only owner of the name of one object, made and deleted in the current context.
template <void (*kDelete)(GLuint)>
class Name {
 public:
  Name() = default;
  explicit Name(GLuint name) : name_(name) {}
  ~Name() {
    if (name_ != 0) kDelete(name_);
  }
  Name(const Name&) = delete;
  Name& operator=(const Name&) = delete;
  Name(Name&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  Name& operator=(Name&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }

  GLuint get() const { return name_; }
  // Gives up the name of an object whose context was lost: in another context the name means something else.
  void forget() { name_ = 0; }

 private:
  GLuint name_ = 0;
};

void delete_buffer(GLuint name);
void delete_vertex_array(GLuint name);
void delete_texture(GLuint name);
void delete_framebuffer(GLuint name);
void delete_renderbuffer(GLuint name);
void delete_program(GLuint name);

using Buffer = Name<delete_buffer>;
using VertexArray = Name<delete_vertex_array>;
using Texture = Name<delete_texture>;
using Framebuffer = Name<delete_framebuffer>;
using Renderbuffer = Name<delete_renderbuffer>;
using Program = Name<delete_program>;

Buffer make_buffer(GLenum target, const void* data, std::size_t bytes);  // stays bound to target
VertexArray make_vertex_array();                                         // stays bound

// Returns a buffer for shaders to read and write: with these bytes, or undefined ones if data is null. Throws GpuError
// if the memory does not suffice or the driver allows no buffer of this size.
Buffer make_storage(const void* data, std::size_t bytes);

void read_storage(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, void* to);
void write_storage(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, const void* from);
void copy_storage(const Buffer& from, const Buffer& to, std::size_t bytes);

// Sets all 32-bit words of the buffer to 0.
void clear_storage(const Buffer& buffer);

// Connects the buffer with the shaders' `binding = place`.
void bind_storage(GLuint place, const Buffer& buffer);

// Returns a texture without mipmaps that is sampled at its texels' centres. Throws InvalidInput if the driver has no
// memory for it.
Texture make_texture(int width, int height, GLenum internal_format);

// Returns a target that draws into the colour textures in this order, and into `depth` if it is not null. Stays bound.
Framebuffer make_framebuffer(std::initializer_list<const Texture*> colors, const Texture* depth);

// Compiles and links shaders; the second, compute shaders. Throws GpuError with the first line of the driver's log.
Program make_program(const std::string& vertex, const std::string& fragment);
Program make_compute_program(const std::string& source);

GLint uniform(const Program& program, const char* name);
void bind_texture(const Program& program, const char* name, int unit, GLenum target, const Texture& texture);

// Throws GpuError for an error that OpenGL has reported.
[[noreturn]] void fail_with(GLenum error);

// Throws GpuError if OpenGL has reported an error since the last call, or the context was lost.
void require_no_error();

}  // namespace knead::gl
