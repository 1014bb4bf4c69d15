#include <algorithm>
#include <utility>

#include "knead/render/drawing.h"
#include "knead/render/live_gpu.h"
#include "knead/render/shaders.h"
#include "knead/render/shadow_map.h"

namespace knead::render {
namespace {

LightMatrix light_matrix(const Vec3d& direction, const Occluder& occluder) {
  const Vec3d u = any_orthogonal(direction);
  const Vec3d rows[3] = {u * (0.5 / occluder.radius), cross(direction, u) * (0.5 / occluder.radius),
                         direction * (-0.5 / occluder.radius)};
  LightMatrix matrix{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) matrix[3 * column + row] = static_cast<float>(rows[row][column]);
    matrix[9 + row] = static_cast<float>(0.5 - dot(rows[row], occluder.center));
  }
  return matrix;
}

// Lights that are drawn in one pass.
struct LightBatch {
  std::vector<LightMatrix> matrices;
  std::vector<Vec3f> directions;
  std::vector<Vec3f> radiances;
  int ground_lights = 0;  // the first ones
};

LightBatch make_batch(std::span<const Light> lights, const Vec3d& up, const Occluder& occluder) {
  LightBatch batch;
  for (const Light& light : lights) {
    batch.matrices.push_back(light_matrix(Vec3d(light.direction), occluder));
    batch.directions.push_back(light.direction);
    batch.radiances.push_back(light.radiance);
    batch.ground_lights += lights_ground(light, up) ? 1 : 0;
  }
  return batch;
}

gl::Texture make_map_array(int size, int layers) {
  GLuint name = 0;
  glGenTextures(1, &name);
  gl::Texture texture(name);
  glBindTexture(GL_TEXTURE_2D_ARRAY, name);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
  glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_R16, size, size, layers, 0, GL_RED, GL_UNSIGNED_SHORT, nullptr);
  return texture;
}

void fill_maps(const gl::Texture& maps, const LightBatch& batch, const Lighting& lighting) {
  const std::vector<std::uint16_t> depths =
      draw_shadow_maps(lighting.occluder, batch.matrices, kShadowMapSize, lighting.point_radius);
  glBindTexture(GL_TEXTURE_2D_ARRAY, maps.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, kShadowMapSize, kShadowMapSize,
                  static_cast<GLsizei>(batch.matrices.size()), GL_RED, GL_UNSIGNED_SHORT, depths.data());
}

// Everything that both lighting programs read.
struct LightInputs {
  const GBuffer& buffer;
  const gl::Texture& maps;
  const gl::Texture* ball;  // of a matcap; null: none
};

void use_lights(const gl::Program& program, const Pass& pass, const LightInputs& inputs, const LightBatch& batch,
                const Lighting& lighting) {
  const Options& options = pass.options;
  const auto count = static_cast<GLsizei>(batch.directions.size());
  use(program, pass);
  set_relief(program, pass.view, pass.height);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, inputs.buffer.depth);
  bind_texture(program, "reflectance_map", 1, GL_TEXTURE_2D, inputs.buffer.reflectance);
  bind_texture(program, "normal_map", 2, GL_TEXTURE_2D, inputs.buffer.normal);
  bind_texture(program, "shadow_maps", 3, GL_TEXTURE_2D_ARRAY, inputs.maps);
  bind_texture(program, "ball", 4, GL_TEXTURE_2D, inputs.ball != nullptr ? *inputs.ball : inputs.buffer.reflectance);
  set(program, "plain_srgb", kClay);
  set(program, "shadow_size", kShadowMapSize);
  set(program, "shadow_range", 2 * lighting.occluder.radius);
  glUniformMatrix4x3fv(uniform(program, "light"), count, GL_FALSE, batch.matrices[0].data());
  glUniform3fv(uniform(program, "direction"), count, &batch.directions[0].x);
  glUniform3fv(uniform(program, "radiance"), count, &batch.radiances[0].x);
  glUniform1i(uniform(program, "light_count"), count);
  glUniform1i(uniform(program, "ground_lights"), batch.ground_lights);
  glUniform1i(uniform(program, "factor"), options.supersampling);
  set(program, "shadows", lighting.has_shadows(options) ? 1.0 : 0.0);
  set(program, "offset", 1.4 * 2 * lighting.occluder.radius / kShadowMapSize);
  set_ground(program, pass, lighting.occluder);
}

gl::Texture draw_ground(const Pass& pass, const gl::Texture& missing, const Lighting& lighting) {
  const int width = (pass.options.width + 1) / 2;
  const int height = (pass.options.height + 1) / 2;
  gl::Texture darkness = gl::make_texture(width, height, GL_RGBA8);
  const gl::Framebuffer target = gl::make_framebuffer({&darkness}, nullptr);
  reset_state(width, height);
  const gl::Program& program = pass.programs.ground;
  use(program, pass);
  bind_texture(program, "ground_map", 0, GL_TEXTURE_2D, missing);
  set(program, "ground_light", lighting.ground_light);
  glUniform1i(uniform(program, "taps"), 64);
  set(program, "reach", lighting.occluder.radius);
  set_ground(program, pass, lighting.occluder);
  draw_full_screen(pass);
  return darkness;
}

}  // namespace

namespace {

// A texture that is drawn in several passes, where the stencil is marked.
struct LightTarget {
  gl::Texture light;
  gl::Renderbuffer stencil;
  gl::Framebuffer framebuffer;
  int width = 0;
  int height = 0;
};

LightTarget make_target(int width, int height) {
  LightTarget target;
  target.width = width;
  target.height = height;
  target.light = gl::make_texture(width, height, GL_RGBA16F);
  target.framebuffer = gl::make_framebuffer({&target.light}, nullptr);
  GLuint name = 0;
  glGenRenderbuffers(1, &name);
  target.stencil = gl::Renderbuffer(name);
  glBindRenderbuffer(GL_RENDERBUFFER, name);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, name);
  reset_state(width, height);
  clear(0, 0, 0, 0);
  glClearStencil(0);
  glClear(GL_STENCIL_BUFFER_BIT);
  return target;
}

// Marks where the program does not discard. Leaves the stencil test on, for what is marked.
void mark(const Pass& pass, const LightTarget& target, const gl::Program& program) {
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 1, 0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.get());
  reset_state(target.width, target.height);
  glUniform1i(uniform(program, "factor"), pass.options.supersampling);
  draw_full_screen(pass);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glDisable(GL_STENCIL_TEST);
}

void mark_even(const Pass& pass, const GBuffer& buffer, const LightTarget& pixels) {
  const gl::Program& program = pass.programs.even;
  use(program, pass);
  set_relief(program, pass.view, pass.height);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  bind_texture(program, "reflectance_map", 1, GL_TEXTURE_2D, buffer.reflectance);
  bind_texture(program, "normal_map", 2, GL_TEXTURE_2D, buffer.normal);
  mark(pass, pixels, program);
}

void mark_uneven(const Pass& pass, const GBuffer& buffer, const LightTarget& pixels, const LightTarget& samples) {
  const gl::Program& program = pass.programs.uneven;
  use(program, pass);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  bind_texture(program, "pixel_map", 1, GL_TEXTURE_2D, pixels.light);
  mark(pass, samples, program);
}

void mark_ground(const Pass& pass, const GBuffer& buffer, const LightTarget& ground) {
  const gl::Program& program = pass.programs.sees_ground;
  use(program, pass);
  bind_texture(program, "depth_map", 0, GL_TEXTURE_2D, buffer.depth);
  mark(pass, ground, program);
}

// Adds light where the target is marked.
void add_light(const Pass& pass, const LightTarget& target) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.get());
  reset_state(target.width, target.height);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_EQUAL, 1, 0xff);
  draw_full_screen(pass);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_BLEND);
}

const gl::Program& shape_program(const Pass& pass) {
  const Options& options = pass.options;
  const ShapeLook look{options.matcap.has_value(), options.relief.cavity, options.relief.occlusion};
  auto& programs = pass.programs.shape_light;
  const auto known = programs.find(look);
  if (known != programs.end()) return known->second;
  const ShaderSource source = shape_light_source(look);
  return programs.emplace(look, gl::make_program(source.vertex, source.fragment)).first->second;
}

}  // namespace

LightMaps draw_light(const Pass& pass, const GBuffer& buffer, const Lighting& lighting) {
  const Options& options = pass.options;
  const bool shadows = lighting.has_shadows(options);
  const bool has_ground = lighting.has_ground(options);
  LightTarget pixels = make_target(options.width, options.height);
  LightTarget samples = make_target(pass.width, pass.height);
  const LightTarget ground = make_target((options.width + 1) / 2, (options.height + 1) / 2);
  mark_even(pass, buffer, pixels);
  if (has_ground) mark_ground(pass, buffer, ground);
  const gl::Texture maps = make_map_array(shadows ? kShadowMapSize : 1, kLightsPerPass);
  const gl::Texture ball = options.matcap ? make_matcap_texture(*options.matcap) : gl::Texture();
  const LightInputs inputs{buffer, maps, options.matcap ? &ball : nullptr};
  const gl::Program& program = shape_program(pass);
  const std::span<const Light> lights = lighting.lights;
  for (std::size_t begin = 0; begin < lights.size(); begin += kLightsPerPass) {
    const std::size_t count = std::min<std::size_t>(kLightsPerPass, lights.size() - begin);
    const LightBatch batch = make_batch(lights.subspan(begin, count), pass.view.ground_up, lighting.occluder);
    if (shadows) fill_maps(maps, batch, lighting);
    // A matcap has all its light in the first pass.
    if (begin == 0 || !options.matcap) {
      use_lights(program, pass, inputs, batch, lighting);
      glUniform1i(uniform(program, "spacing"), options.supersampling);
      add_light(pass, pixels);
      if (begin == 0) mark_uneven(pass, buffer, pixels, samples);
      use_lights(program, pass, inputs, batch, lighting);
      glUniform1i(uniform(program, "spacing"), 1);
      add_light(pass, samples);
    }
    if (has_ground && batch.ground_lights > 0) {
      use_lights(pass.programs.ground_light, pass, inputs, batch, lighting);
      add_light(pass, ground);
    }
    report(pass, 0.25 + 0.45 * static_cast<double>(begin + count) / static_cast<double>(lights.size()));
  }
  LightMaps result{std::move(pixels.light), std::move(samples.light), gl::Texture()};
  if (has_ground) result.darkness = draw_ground(pass, ground.light, lighting);
  report(pass, 0.8);
  return result;
}

}  // namespace knead::render
