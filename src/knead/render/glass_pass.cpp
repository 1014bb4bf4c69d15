#include "knead/render/drawing.h"

namespace knead::render {
namespace {

constexpr std::size_t kMostLayers = 16;
constexpr double kLineWidth = 1.6;  // in pixels, of the line where glass meets a shape

}  // namespace

void draw_rods(const Pass& pass, const GBuffer& buffer, const gl::Texture& color, const SurfaceBuffers& rods) {
  if (rods.count == 0) return;
  const gl::Framebuffer target = gl::make_framebuffer({&color, &buffer.normal}, &buffer.depth);
  reset_state(pass.width, pass.height);
  const gl::Program& program = pass.programs.rod;
  use(program, pass);
  set_simple_light(program, pass.view);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  // First what a shape hides, as a shine; then what is in plain sight.
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glColorMaski(1, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  set(program, "opacity", 0.4);
  draw(rods);
  glDisable(GL_BLEND);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMaski(1, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  set(program, "opacity", 1.0);
  draw(rods);
}

namespace {

// Draws the layer behind `before` into the bound framebuffer; tells whether there was one.
bool draw_layer(const Pass& pass, const GBuffer& buffer, const std::vector<SurfaceBuffers>& surfaces,
                const gl::Texture& before) {
  const gl::Program& program = pass.programs.glass;
  use(program, pass);
  set_simple_light(program, pass.view);
  glEnable(GL_DEPTH_TEST);
  clear(0, 0, 0, 0);
  clear_depth();
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  bind_texture(program, "normal_map", 1, GL_TEXTURE_2D, buffer.normal);
  bind_texture(program, "layer_map", 2, GL_TEXTURE_2D, before);
  set(program, "pixel", pass.view.pixel);
  set(program, "line_width", kLineWidth * pass.options.supersampling);
  GLuint query = 0;
  glGenQueries(1, &query);
  glBeginQuery(GL_SAMPLES_PASSED, query);
  for (const SurfaceBuffers& surface : surfaces) {
    set_with_alpha(program, "glass", surface.color);
    draw(surface);
  }
  glEndQuery(GL_SAMPLES_PASSED);
  GLuint drawn = 0;
  glGetQueryObjectuiv(query, GL_QUERY_RESULT, &drawn);
  glDeleteQueries(1, &query);
  return drawn > 0;
}

void copy(const Pass& pass, const gl::Texture& texture) {
  use(pass.programs.copy, pass);
  bind_texture(pass.programs.copy, "layer", 0, GL_TEXTURE_2D, texture);
  draw_full_screen(pass);
}

}  // namespace

void draw_glass(const Pass& pass, const GBuffer& buffer, const gl::Texture& color,
                const std::vector<SurfaceBuffers>& surfaces) {
  if (surfaces.empty()) return;
  const gl::Texture over = gl::make_texture(pass.width, pass.height, GL_RGBA16F);
  const gl::Framebuffer over_target = gl::make_framebuffer({&over}, nullptr);
  clear(0, 0, 0, 0);
  const gl::Texture layer = gl::make_texture(pass.width, pass.height, GL_RGBA16F);
  const gl::Texture depths[2] = {gl::make_texture(pass.width, pass.height, GL_DEPTH_COMPONENT32F),
                                 gl::make_texture(pass.width, pass.height, GL_DEPTH_COMPONENT32F)};
  const gl::Framebuffer targets[2] = {gl::make_framebuffer({&layer}, &depths[0]),
                                      gl::make_framebuffer({&layer}, &depths[1])};
  reset_state(pass.width, pass.height);
  glClearDepth(0);
  glClear(GL_DEPTH_BUFFER_BIT);  // depths[1]: nothing is drawn yet
  for (std::size_t i = 0; i < kMostLayers; ++i) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets[i % 2].get());
    reset_state(pass.width, pass.height);
    if (!draw_layer(pass, buffer, surfaces, depths[1 - i % 2])) break;
    glBindFramebuffer(GL_FRAMEBUFFER, over_target.get());
    reset_state(pass.width, pass.height);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    copy(pass, layer);
  }
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  reset_state(pass.width, pass.height);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  copy(pass, over);
}

}  // namespace knead::render
