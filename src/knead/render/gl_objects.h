// Owners of OpenGL names: made in the current context, deleted in it.
#pragma once

#include <epoxy/gl.h>

#include <initializer_list>
#include <span>
#include <string>
#include <utility>

namespace knead::render {

// Move-only owner of one name.
template <void (*kDelete)(GLuint)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  ~GlName() {
    if (name_ != 0) kDelete(name_);
  }
  GlName(const GlName&) = delete;
  GlName& operator=(const GlName&) = delete;
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }

  GLuint get() const { return name_; }

 private:
  GLuint name_ = 0;
};

void delete_buffer(GLuint name);
void delete_vertex_array(GLuint name);
void delete_texture(GLuint name);
void delete_framebuffer(GLuint name);
void delete_sampler(GLuint name);
void delete_renderbuffer(GLuint name);
void delete_shader(GLuint name);
void delete_program(GLuint name);

using Buffer = GlName<delete_buffer>;
using VertexArray = GlName<delete_vertex_array>;
using Texture = GlName<delete_texture>;
using Framebuffer = GlName<delete_framebuffer>;
using Sampler = GlName<delete_sampler>;
using Renderbuffer = GlName<delete_renderbuffer>;
using Program = GlName<delete_program>;

Buffer make_buffer(GLenum target, const void* data, std::size_t bytes);  // stays bound to target
VertexArray make_vertex_array();                                         // stays bound

// A texture without mipmaps, sampled at its texels' centres. Throws InvalidInput if the driver has no memory for it.
Texture make_texture(int width, int height, GLenum internal_format);

// Depth maps compared with linear filtering; outside of them everything is lit.
Texture make_shadow_array(int size, int layers);

// Reads a shadow array's depths instead of comparing them.
Sampler make_plain_depth_sampler();

// Draws into the colour textures in this order, and the depth texture if it is not null. Stays bound.
Framebuffer make_framebuffer(std::initializer_list<const Texture*> colors, const Texture* depth);

// Throws std::runtime_error with the driver's first words where the source does not compile or link.
Program make_program(const std::string& vertex, const std::string& fragment);

// The same for compute shaders, which need OpenGL 4.3.
Program make_compute_program(const std::string& source);

GLint uniform(const Program& program, const char* name);
void bind_texture(const Program& program, const char* name, int unit, GLenum target, const Texture& texture);

}  // namespace knead::render
