#include "knead/render/passes.h"

#include <algorithm>
#include <cstddef>

#include "knead/render/shaders.h"

namespace knead::render {
namespace {

constexpr int kMostLayers = 16;
constexpr float kLineWidth = 1.6f;  // in pixels, of the line where glass meets a shape

Program compile(const ShaderSource& source) { return make_program(source.vertex, source.fragment); }

void set(const Program& program, const char* name, const Vec3d& v) {
  glUniform3f(uniform(program, name), static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
}

void set(const Program& program, const char* name, double x) {
  glUniform1f(uniform(program, name), static_cast<float>(x));
}

void set(const Program& program, const char* name, const Color& c) {
  glUniform3f(uniform(program, name), c.red, c.green, c.blue);
}

void set_with_alpha(const Program& program, const char* name, const Color& c) {
  glUniform4f(uniform(program, name), c.red, c.green, c.blue, c.alpha);
}

// Makes the program current and tells it of the camera and the clipping plane.
void use(const Program& program, const Pass& pass) {
  const View& view = pass.view;
  glUseProgram(program.get());
  set(program, "eye", view.eye);
  set(program, "forward", view.frame.forward);
  set(program, "side", view.side);
  set(program, "top", view.top);
  glUniform2f(uniform(program, "range"), static_cast<float>(view.near), static_cast<float>(view.far));
  set(program, "perspective", view.perspective ? 1.0 : 0.0);
  glUniform2f(uniform(program, "samples"), static_cast<float>(pass.width), static_cast<float>(pass.height));
  glUniformMatrix4fv(uniform(program, "matrix"), 1, GL_FALSE, view.matrix.data());
  glUniform4fv(uniform(program, "clip"), 1, pass.clip.data());
}

void set_simple_light(const Program& program, const View& view) {
  set(program, "sky_up", view.ground_up);
  set(program, "key", normalized(view.frame.up * 0.9 - view.frame.right * 0.6 - view.frame.forward * 0.8));
}

void set_ground(const Program& program, const Pass& pass, const GpuOccluder& occluder) {
  const Vec3f up(pass.view.ground_up);
  glUniform4f(uniform(program, "ground"), up.x, up.y, up.z, static_cast<float>(occluder.ground));
}

void draw(const GpuSurface& surface) {
  if (surface.count == 0) return;
  glBindVertexArray(surface.layout.get());
  if (surface.points) {
    glDrawArrays(GL_POINTS, 0, surface.count);
  } else {
    glDrawElements(GL_TRIANGLES, surface.count, GL_UNSIGNED_INT, nullptr);
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
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_CLIP_DISTANCE0);
  glEnable(GL_PROGRAM_POINT_SIZE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

void clear(float red, float green, float blue, float alpha) {
  glClearColor(red, green, blue, alpha);
  glClear(GL_COLOR_BUFFER_BIT);
}

void clear_depth() {
  glClearDepth(1);
  glClear(GL_DEPTH_BUFFER_BIT);
}

void describe_attribute(GLuint location, GLint components, GLenum type, std::size_t stride, std::size_t offset) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, components, type, type == GL_UNSIGNED_BYTE ? GL_TRUE : GL_FALSE,
                        static_cast<GLsizei>(stride), reinterpret_cast<const void*>(offset));
}

GpuSurface upload_positions(const std::vector<Vec3f>& positions, const std::vector<std::uint32_t>& indices) {
  GpuSurface surface;
  surface.layout = make_vertex_array();
  surface.vertices = make_buffer(GL_ARRAY_BUFFER, positions.data(), positions.size() * sizeof(Vec3f));
  surface.indices = make_buffer(GL_ELEMENT_ARRAY_BUFFER, indices.data(), indices.size() * sizeof(std::uint32_t));
  describe_attribute(0, 3, GL_FLOAT, sizeof(Vec3f), 0);
  surface.points = indices.empty();
  surface.count = static_cast<GLsizei>(surface.points ? positions.size() : indices.size());
  return surface;
}

}  // namespace

Programs::Programs()
    : clay(compile(clay_source())),
      cap(compile(cap_source())),
      disc(compile(disc_source())),
      shadow(compile(shadow_source())),
      lighting(compile(lighting_source())),
      backdrop(compile(backdrop_source())),
      rod(compile(rod_source())),
      glass(compile(glass_source())),
      copy(compile(copy_source())),
      resolve(compile(resolve_source())),
      nothing(make_vertex_array()),
      plain_depth(make_plain_depth_sampler()) {}

GpuSurface upload(const DrawSurface& surface) {
  GpuSurface result;
  result.layout = make_vertex_array();
  result.vertices = make_buffer(GL_ARRAY_BUFFER, surface.vertices.data(), surface.vertices.size() * sizeof(DrawVertex));
  result.indices =
      make_buffer(GL_ELEMENT_ARRAY_BUFFER, surface.indices.data(), surface.indices.size() * sizeof(std::uint32_t));
  describe_attribute(0, 3, GL_FLOAT, sizeof(DrawVertex), offsetof(DrawVertex, position));
  describe_attribute(1, 3, GL_FLOAT, sizeof(DrawVertex), offsetof(DrawVertex, normal));
  describe_attribute(2, 4, GL_UNSIGNED_BYTE, sizeof(DrawVertex), offsetof(DrawVertex, color));
  describe_attribute(3, 4, GL_UNSIGNED_BYTE, sizeof(DrawVertex), offsetof(DrawVertex, edge));
  result.points = surface.indices.empty();
  result.count = static_cast<GLsizei>(result.points ? surface.vertices.size() : surface.indices.size());
  return result;
}

GpuOccluder upload(const Occluder& occluder, double point_radius) {
  GpuOccluder result{upload_positions(occluder.positions, occluder.indices), upload_positions(occluder.points, {}),
                     occluder.center, occluder.radius, occluder.ground};
  result.points.point_radius = point_radius;
  return result;
}

GBuffer draw_shapes(const Pass& pass, const std::vector<GpuSurface>& shapes) {
  GBuffer buffer{make_texture(pass.width, pass.height, GL_DEPTH_COMPONENT32F),
                 make_texture(pass.width, pass.height, GL_RGBA8), make_texture(pass.width, pass.height, GL_RGBA16F)};
  const Framebuffer target = make_framebuffer({&buffer.reflectance, &buffer.normal}, &buffer.depth);
  reset_state(pass.width, pass.height);
  glEnable(GL_DEPTH_TEST);
  if (pass.clipped) glEnable(GL_CLIP_DISTANCE0);
  clear(0, 0, 0, 0);
  clear_depth();
  for (const GpuSurface& shape : shapes) {
    const Programs& programs = pass.programs;
    const Program& program = shape.points ? programs.disc : (pass.clipped ? programs.cap : programs.clay);
    use(program, pass);
    set(program, "back_srgb", shape.color);
    set(program, "cut_srgb", pass.cut);
    set(program, "wire_width", pass.options.wireframe ? 1.1 * pass.options.supersampling : 0.0);
    set(program, "point_size", 2 * shape.point_radius / pass.view.pixel);
    draw(shape);
  }
  return buffer;
}

namespace {

// To 0..1 in a light's map, by columns; depth 0 is nearest to the light.
std::array<float, 12> light_matrix(const Vec3d& direction, const GpuOccluder& occluder) {
  const Vec3d u = any_orthogonal(direction);
  const Vec3d rows[3] = {u * (0.5 / occluder.radius), cross(direction, u) * (0.5 / occluder.radius),
                         direction * (-0.5 / occluder.radius)};
  std::array<float, 12> matrix{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) matrix[3 * column + row] = static_cast<float>(rows[row][column]);
    matrix[9 + row] = static_cast<float>(0.5 - dot(rows[row], occluder.center));
  }
  return matrix;
}

struct LightBatch {
  std::vector<float> matrices;
  std::vector<Vec3f> directions;
  std::vector<Vec3f> radiances;
};

LightBatch make_batch(std::span<const Light> lights, const GpuOccluder& occluder) {
  LightBatch batch;
  for (const Light& light : lights) {
    const auto matrix = light_matrix(Vec3d(light.direction), occluder);
    batch.matrices.insert(batch.matrices.end(), matrix.begin(), matrix.end());
    batch.directions.push_back(light.direction);
    batch.radiances.push_back(light.radiance);
  }
  return batch;
}

void draw_shadow_maps(const Pass& pass, const LightBatch& batch, const GpuOccluder& occluder, const Texture& maps) {
  const Program& program = pass.programs.shadow;
  glUseProgram(program.get());
  reset_state(kShadowMapSize, kShadowMapSize);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5f, 0);
  if (pass.clipped) glEnable(GL_CLIP_DISTANCE0);
  glUniform4fv(uniform(program, "clip"), 1, pass.clip.data());
  set(program, "point_size", occluder.points.point_radius / occluder.radius * kShadowMapSize);
  for (std::size_t i = 0; i < batch.directions.size(); ++i) {
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, maps.get(), 0, static_cast<GLint>(i));
    clear_depth();
    glUniformMatrix4x3fv(uniform(program, "light"), 1, GL_FALSE, batch.matrices.data() + 12 * i);
    draw(occluder.triangles);
    draw(occluder.points);
  }
}

void add_light(const Pass& pass, const GBuffer& buffer, const LightBatch& batch, const GpuOccluder& occluder,
               const Texture& maps) {
  const Program& program = pass.programs.lighting;
  const bool shadows = pass.options.ambient_occlusion && occluder.radius > 0;
  const auto count = static_cast<GLsizei>(batch.directions.size());
  use(program, pass);
  reset_state(pass.width, pass.height);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  bind_texture(program, "reflectance_map", 1, GL_TEXTURE_2D, buffer.reflectance);
  bind_texture(program, "normal_map", 2, GL_TEXTURE_2D, buffer.normal);
  bind_texture(program, "shadow_maps", 3, GL_TEXTURE_2D_ARRAY, maps);
  bind_texture(program, "shadow_depths", 4, GL_TEXTURE_2D_ARRAY, maps);
  glBindSampler(4, pass.programs.plain_depth.get());
  set(program, "shadow_range", 2 * occluder.radius);
  glUniformMatrix4x3fv(uniform(program, "light"), count, GL_FALSE, batch.matrices.data());
  glUniform3fv(uniform(program, "direction"), count, &batch.directions[0].x);
  glUniform3fv(uniform(program, "radiance"), count, &batch.radiances[0].x);
  glUniform1i(uniform(program, "light_count"), count);
  glUniform1i(uniform(program, "side_groups"), pass.options.supersampling);
  set(program, "shadows", shadows ? 1.0 : 0.0);
  set(program, "offset", 2.0 * 2 * occluder.radius / kShadowMapSize);
  set_ground(program, pass, occluder);
  set(program, "with_ground", shadows && pass.options.ground ? 1.0 : 0.0);
  draw_full_screen(pass);
  glBindSampler(4, 0);
}

}  // namespace

Texture draw_light(const Pass& pass, const GBuffer& buffer, const std::vector<Light>& lights,
                   const GpuOccluder& occluder) {
  const int groups = pass.options.supersampling * pass.options.supersampling;
  const auto per_pass = static_cast<std::size_t>(kLightsPerPass / groups * groups);
  const bool shadows = pass.options.ambient_occlusion && occluder.radius > 0;
  Texture light = make_texture(pass.width, pass.height, GL_RGBA32F);
  const Framebuffer light_target = make_framebuffer({&light}, nullptr);
  clear(0, 0, 0, 0);
  const Texture maps = make_shadow_array(shadows ? kShadowMapSize : 1, kLightsPerPass);
  const Framebuffer shadow_target = make_framebuffer({}, nullptr);
  for (std::size_t begin = 0; begin < lights.size(); begin += per_pass) {
    const std::size_t count = std::min(per_pass, lights.size() - begin);
    const LightBatch batch = make_batch(std::span(lights).subspan(begin, count), occluder);
    if (shadows) {
      glBindFramebuffer(GL_FRAMEBUFFER, shadow_target.get());
      draw_shadow_maps(pass, batch, occluder, maps);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, light_target.get());
    add_light(pass, buffer, batch, occluder, maps);
  }
  return light;
}

Texture draw_backdrop(const Pass& pass, const GBuffer& buffer, const Texture& light, const GpuOccluder& occluder,
                      double ground_light) {
  Texture color = make_texture(pass.width, pass.height, GL_RGBA16F);
  const Framebuffer target = make_framebuffer({&color}, nullptr);
  reset_state(pass.width, pass.height);
  const Program& program = pass.programs.backdrop;
  use(program, pass);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  bind_texture(program, "light_map", 1, GL_TEXTURE_2D, light);
  set_with_alpha(program, "background", pass.options.background);
  set(program, "ground_light", ground_light);
  glUniform1i(uniform(program, "taps"), std::max(24, 64 / (pass.options.supersampling * pass.options.supersampling)));
  set(program, "reach", pass.options.ambient_occlusion && pass.options.ground ? occluder.radius : 0.0);
  set_ground(program, pass, occluder);
  draw_full_screen(pass);
  return color;
}

void draw_rods(const Pass& pass, const GBuffer& buffer, const Texture& color, const GpuSurface& rods) {
  if (rods.count == 0) return;
  const Framebuffer target = make_framebuffer({&color, &buffer.normal}, &buffer.depth);
  reset_state(pass.width, pass.height);
  const Program& program = pass.programs.rod;
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
bool draw_layer(const Pass& pass, const GBuffer& buffer, const std::vector<GpuSurface>& surfaces,
                const Texture& before) {
  const Program& program = pass.programs.glass;
  use(program, pass);
  set_simple_light(program, pass.view);
  glEnable(GL_DEPTH_TEST);
  clear(0, 0, 0, 0);
  clear_depth();
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  bind_texture(program, "normal_map", 1, GL_TEXTURE_2D, buffer.normal);
  bind_texture(program, "layer_map", 2, GL_TEXTURE_2D, before);
  set(program, "pixel", pass.view.pixel);
  set(program, "line_width", static_cast<double>(kLineWidth) * pass.options.supersampling);
  GLuint query = 0;
  glGenQueries(1, &query);
  glBeginQuery(GL_SAMPLES_PASSED, query);
  for (const GpuSurface& surface : surfaces) {
    set_with_alpha(program, "glass", surface.color);
    draw(surface);
  }
  glEndQuery(GL_SAMPLES_PASSED);
  GLuint drawn = 0;
  glGetQueryObjectuiv(query, GL_QUERY_RESULT, &drawn);
  glDeleteQueries(1, &query);
  return drawn > 0;
}

}  // namespace

Texture draw_glass(const Pass& pass, const GBuffer& buffer, const std::vector<GpuSurface>& surfaces) {
  Texture over = make_texture(pass.width, pass.height, GL_RGBA16F);
  const Framebuffer over_target = make_framebuffer({&over}, nullptr);
  clear(0, 0, 0, 0);
  if (surfaces.empty()) return over;
  const Texture layer = make_texture(pass.width, pass.height, GL_RGBA16F);
  const Texture depths[2] = {make_texture(pass.width, pass.height, GL_DEPTH_COMPONENT32F),
                             make_texture(pass.width, pass.height, GL_DEPTH_COMPONENT32F)};
  const Framebuffer targets[2] = {make_framebuffer({&layer}, &depths[0]), make_framebuffer({&layer}, &depths[1])};
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
    use(pass.programs.copy, pass);
    bind_texture(pass.programs.copy, "layer", 0, GL_TEXTURE_2D, layer);
    draw_full_screen(pass);
  }
  return over;
}

Image resolve(const Pass& pass, const Texture& base, const Texture& over) {
  Image image{pass.options.width, pass.options.height, {}};
  const Texture pixels = make_texture(image.width, image.height, GL_RGBA8);
  const Framebuffer target = make_framebuffer({&pixels}, nullptr);
  reset_state(image.width, image.height);
  const Program& program = pass.programs.resolve;
  use(program, pass);
  bind_texture(program, "base", 0, GL_TEXTURE_2D, base);
  bind_texture(program, "over", 1, GL_TEXTURE_2D, over);
  glUniform1i(uniform(program, "factor"), pass.options.supersampling);
  glUniform1i(uniform(program, "height"), image.height);
  draw_full_screen(pass);
  image.pixels.resize(4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
  return image;
}

}  // namespace knead::render
