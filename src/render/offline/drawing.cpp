// Small steps that the passes share: uniforms, state, and buffers of surfaces.
#include <cstddef>

#include "render/offline/passes.h"

namespace knead::render {

void set(const gl::Program& program, const char* name, const Vec3d& v) {
  glUniform3f(uniform(program, name), static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
}

void set(const gl::Program& program, const char* name, double x) {
  glUniform1f(uniform(program, name), static_cast<float>(x));
}

void set(const gl::Program& program, const char* name, const Color& c) {
  glUniform3f(uniform(program, name), c.red, c.green, c.blue);
}

void set_with_alpha(const gl::Program& program, const char* name, const Color& c) {
  glUniform4f(uniform(program, name), c.red, c.green, c.blue, c.alpha);
}

void use(const gl::Program& program, const View& view, int width, int height) {
  glUseProgram(program.get());
  set(program, "eye", view.eye);
  set(program, "forward", view.frame.forward);
  set(program, "side", view.side);
  set(program, "top", view.top);
  glUniform2f(uniform(program, "shift"), static_cast<float>(view.shift_x), static_cast<float>(view.shift_y));
  glUniform2f(uniform(program, "range"), static_cast<float>(view.near), static_cast<float>(view.far));
  set(program, "perspective", view.perspective ? 1.0 : 0.0);
  glUniform2f(uniform(program, "samples"), static_cast<float>(width), static_cast<float>(height));
  glUniformMatrix4fv(uniform(program, "matrix"), 1, GL_FALSE, view.matrix.data());
  glUniform4f(uniform(program, "clip"), 0, 0, 0, 1);
}

// Shaders count samples from the part's corner.
void use(const gl::Program& program, const Pass& pass) {
  use(program, pass.view, pass.width, pass.height);
  glUniform2f(uniform(program, "shift"), static_cast<float>(pass.view.shift_x - 2.0 * pass.part.left / pass.width),
              static_cast<float>(pass.view.shift_y - 2.0 * pass.part.bottom / pass.height));
}

void use_clipped(const gl::Program& program, const Pass& pass) {
  use(program, pass);
  if (!pass.clipped) return;
  glUniform4fv(uniform(program, "clip"), 1, pass.clip.data());
  gl::set_clipping(true);
}

void set_simple_light(const gl::Program& program, const View& view) {
  set(program, "sky_up", view.ground_up);
  set(program, "key", normalized(view.frame.up * 0.9 - view.frame.right * 0.6 - view.frame.forward * 0.8));
}

void set_relief(const gl::Program& program, const View& view, int samples_high) {
  set(program, "sample_size", view.pixel);
  set(program, "cavity_step", kFinestCavity * samples_high);
  set(program, "occlusion_reach", kOcclusionReach);
}

void draw(const SurfaceBuffers& surface) { draw(surface, 0, surface.count); }

void draw(const SurfaceBuffers& surface, GLsizei first, GLsizei count) {
  if (count == 0) return;
  glBindVertexArray(surface.layout.get());
  if (surface.points) {
    glDrawArrays(GL_POINTS, first, count);
  } else {
    const std::size_t offset = sizeof(std::uint32_t) * static_cast<std::size_t>(first);
    const auto* start = reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr): as OpenGL takes it
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, start);
  }
}

void draw_full_screen(const Pass& pass) {
  glBindVertexArray(pass.programs.nothing.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void reset_state(int width, int height) {
  glViewport(0, 0, width, height);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_POLYGON_OFFSET_FILL);
  gl::set_clipping(false);
  gl::let_shaders_size_points();
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

void reset_state(const Pass& pass) {
  reset_state(pass.width, pass.height);
  glViewport(-pass.part.left, -pass.part.bottom, pass.width, pass.height);
}

gl::Texture make_texture(const Pass& pass, GLenum internal_format) {
  return gl::make_texture(pass.part.width, pass.part.height, internal_format);
}

void clear(float red, float green, float blue, float alpha) {
  glClearColor(red, green, blue, alpha);
  glClear(GL_COLOR_BUFFER_BIT);
}

void clear_depth() {
  gl::clear_depth_to(1);
  glClear(GL_DEPTH_BUFFER_BIT);
}

namespace {

void describe_attribute(GLuint location, GLint components, GLenum type, std::size_t stride, std::size_t offset) {
  const auto* start = reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr): as OpenGL takes it
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, components, type, type == GL_UNSIGNED_BYTE ? GL_TRUE : GL_FALSE,
                        static_cast<GLsizei>(stride), start);
}

}  // namespace

Programs::Programs()
    : clay(compile(clay_source())),
      wired(compile(wired_source())),
      cap(compile(cap_source())),
      disc(compile(disc_source())),
      rod(compile(rod_source())),
      glass(compile(glass_source())),
      copy(compile(copy_source())),
      nothing(gl::make_vertex_array()) {}

SurfaceBuffers upload(const DrawSurface& surface) {
  SurfaceBuffers result;
  result.layout = gl::make_vertex_array();
  result.vertices =
      gl::make_buffer(GL_ARRAY_BUFFER, surface.vertices.data(), surface.vertices.size() * sizeof(DrawVertex));
  result.indices =
      gl::make_buffer(GL_ELEMENT_ARRAY_BUFFER, surface.indices.data(), surface.indices.size() * sizeof(std::uint32_t));
  describe_attribute(0, 3, GL_FLOAT, sizeof(DrawVertex), offsetof(DrawVertex, position));
  describe_attribute(1, 3, GL_FLOAT, sizeof(DrawVertex), offsetof(DrawVertex, normal));
  describe_attribute(2, 4, GL_UNSIGNED_BYTE, sizeof(DrawVertex), offsetof(DrawVertex, color));
  describe_attribute(3, 4, GL_UNSIGNED_BYTE, sizeof(DrawVertex), offsetof(DrawVertex, edge));
  result.points = surface.indices.empty();
  result.count = static_cast<GLsizei>(result.points ? surface.vertices.size() : surface.indices.size());
  return result;
}

void report(const Pass& pass, double part) {
  *pass.reported = part;
  if (!pass.options.progress) return;
  glFinish();
  pass.options.progress(part);
}

}  // namespace knead::render
