#include <algorithm>

#include "knead/render/drawing.h"
#include "knead/render/shaders.h"

namespace knead::render {
namespace {

// To 0..1 in a light's map, by columns; depth 0 is nearest to the light.
std::array<float, 12> light_matrix(const Vec3d& direction, const OccluderBuffers& occluder) {
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

LightBatch make_batch(std::span<const Light> lights, const OccluderBuffers& occluder) {
  LightBatch batch;
  for (const Light& light : lights) {
    const auto matrix = light_matrix(Vec3d(light.direction), occluder);
    batch.matrices.insert(batch.matrices.end(), matrix.begin(), matrix.end());
    batch.directions.push_back(light.direction);
    batch.radiances.push_back(light.radiance);
  }
  return batch;
}

void draw_shadow_maps(const Pass& pass, const LightBatch& batch, const OccluderBuffers& occluder,
                      const gl::Texture& maps) {
  const gl::Program& program = pass.programs.shadow;
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

void add_light(const Pass& pass, const GBuffer& buffer, const LightBatch& batch, const OccluderBuffers& occluder,
               const gl::Texture& maps) {
  const gl::Program& program = pass.programs.lighting;
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

gl::Texture draw_light(const Pass& pass, const GBuffer& buffer, const std::vector<Light>& lights,
                       const OccluderBuffers& occluder) {
  const int groups = pass.options.supersampling * pass.options.supersampling;
  const int lights_per_pass = kLightsPerPass / groups * groups;
  const auto per_pass = static_cast<std::size_t>(lights_per_pass);
  const bool shadows = pass.options.ambient_occlusion && occluder.radius > 0;
  gl::Texture light = gl::make_texture(pass.width, pass.height, GL_RGBA32F);
  const gl::Framebuffer light_target = gl::make_framebuffer({&light}, nullptr);
  clear(0, 0, 0, 0);
  const gl::Texture maps = gl::make_shadow_array(shadows ? kShadowMapSize : 1, kLightsPerPass);
  const gl::Framebuffer shadow_target = gl::make_framebuffer({}, nullptr);
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

}  // namespace knead::render
