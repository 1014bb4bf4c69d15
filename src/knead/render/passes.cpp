#include "knead/render/drawing.h"

namespace knead::render {

namespace {

// Closes the shapes that are already drawn where the clipping plane has opened them.
void draw_cuts(const Pass& pass, const std::vector<SurfaceBuffers>& shapes, const gl::Framebuffer& target) {
  const gl::Texture nearest = gl::make_texture(pass.width, pass.height, GL_DEPTH_COMPONENT32F);
  const gl::Framebuffer copy = gl::make_framebuffer({}, &nearest);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.get());
  glBlitFramebuffer(0, 0, pass.width, pass.height, 0, 0, pass.width, pass.height, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  const gl::Program& program = pass.programs.cap;
  use_clipped(program, pass);
  bind_texture(program, "nearest_map", 0, GL_TEXTURE_2D, nearest);
  set(program, "cut_srgb", pass.cut);
  for (const SurfaceBuffers& shape : shapes) {
    if (!shape.points) draw(shape);
  }
}

}  // namespace

GBuffer draw_shapes(const Pass& pass, const std::vector<SurfaceBuffers>& shapes) {
  GBuffer buffer{gl::make_texture(pass.width, pass.height, GL_DEPTH_COMPONENT32F),
                 gl::make_texture(pass.width, pass.height, GL_RGBA8),
                 gl::make_texture(pass.width, pass.height, GL_RGBA16F)};
  const gl::Framebuffer target = gl::make_framebuffer({&buffer.reflectance, &buffer.normal}, &buffer.depth);
  reset_state(pass.width, pass.height);
  glEnable(GL_DEPTH_TEST);
  clear(0, 0, 0, 0);
  clear_depth();
  for (const SurfaceBuffers& shape : shapes) {
    const gl::Program& program = shape.points ? pass.programs.disc : pass.programs.clay;
    use_clipped(program, pass);
    set(program, "back_srgb", shape.color);
    set(program, "wire_width", pass.options.wireframe ? 1.1 * pass.options.supersampling : 0.0);
    set(program, "point_size", 2 * shape.point_radius / pass.view.pixel);
    draw(shape);
  }
  if (pass.clipped) draw_cuts(pass, shapes, target);
  return buffer;
}

gl::Texture draw_backdrop(const Pass& pass, const GBuffer& buffer, const LightMaps& light, const Lighting& lighting) {
  gl::Texture color = gl::make_texture(pass.width, pass.height, GL_RGBA16F);
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  reset_state(pass.width, pass.height);
  const gl::Program& program = pass.programs.backdrop;
  use(program, pass);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  const bool ground = lighting.has_ground(pass.options);
  bind_texture(program, "pixel_map", 1, GL_TEXTURE_2D, light.pixels);
  bind_texture(program, "sample_map", 2, GL_TEXTURE_2D, light.samples);
  bind_texture(program, "darkness_map", 3, GL_TEXTURE_2D, ground ? light.darkness : light.pixels);
  set_with_alpha(program, "background_top", pass.options.background);
  set_with_alpha(program, "background_bottom", pass.options.background_bottom.value_or(pass.options.background));
  set(program, "with_ground", ground ? 1.0 : 0.0);
  glUniform1i(uniform(program, "factor"), pass.options.supersampling);
  draw_full_screen(pass);
  return color;
}

Image resolve(const Pass& pass, const gl::Texture& color) {
  Image image{pass.options.width, pass.options.height, {}};
  const gl::Texture pixels = gl::make_texture(image.width, image.height, GL_RGBA8);
  const gl::Framebuffer target = gl::make_framebuffer({&pixels}, nullptr);
  reset_state(image.width, image.height);
  const gl::Program& program = pass.programs.resolve;
  use(program, pass);
  bind_texture(program, "samples_map", 0, GL_TEXTURE_2D, color);
  glUniform1i(uniform(program, "factor"), pass.options.supersampling);
  glUniform1i(uniform(program, "height"), image.height);
  draw_full_screen(pass);
  image.pixels.resize(4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
  return image;
}

}  // namespace knead::render
