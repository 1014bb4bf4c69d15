#include <algorithm>
#include <cmath>
#include <utility>

#include "knead/error.h"
#include "render/live/live.h"
#include "render/offline/passes.h"

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

namespace {

constexpr std::size_t kMaxLayers = 16;
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
  for (std::size_t i = 0; i < kMaxLayers; ++i) {
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

namespace {

constexpr float kFarthest = 65535;
constexpr float kSlopeShift = 1.5f;

// In texels across, and in steps of depth.
struct MapPoint {
  float x;
  float y;
  float z;
};

struct Map {
  int size;
  std::uint16_t* depths;

  void put(int x, int y, float z) const {
    std::uint16_t& depth = depths[static_cast<std::ptrdiff_t>(y) * size + x];
    depth = std::min(depth, static_cast<std::uint16_t>(std::clamp(z, 0.0f, kFarthest)));
  }

  // The texels whose centres lie in [from, to]: first and one past the last.
  int first(float from) const { return std::max(0, static_cast<int>(std::ceil(std::max(from, -1.0f) - 0.5f))); }
  int end(float to) const {
    return std::min(size, static_cast<int>(std::floor(std::min(to, static_cast<float>(size)) - 0.5f)) + 1);
  }
};

MapPoint place(const LightMatrix& m, const Vec3f& p, float size) {
  const auto row = [&](std::size_t i) { return m[i] * p.x + m[3 + i] * p.y + m[6 + i] * p.z + m[9 + i]; };
  return {row(0) * size, row(1) * size, row(2) * kFarthest};
}

// A plane over the map: value(x, y) = at + dx * x + dy * y.
struct Plane {
  float at;
  float dx;
  float dy;

  float operator()(float x, float y) const { return at + dx * x + dy * y; }
};

// At least 0 on the left of the way from a to b.
Plane left_of(const MapPoint& a, const MapPoint& b) {
  const float dx = b.x - a.x;
  const float dy = b.y - a.y;
  return {dy * a.x - dx * a.y, -dy, dx};
}

// Most triangles are about as large as a texel: each texel of the box around them is tried.
void draw_triangle(const Map& map, const MapPoint& a, const MapPoint& b, const MapPoint& c) {
  const int top = map.first(std::min({a.y, b.y, c.y}));
  const int bottom = map.end(std::max({a.y, b.y, c.y}));
  const int left = map.first(std::min({a.x, b.x, c.x}));
  const int right = map.end(std::max({a.x, b.x, c.x}));
  if (top >= bottom || left >= right) return;
  // From a, so that the numbers are small.
  const MapPoint origin{0, 0, 0};
  const MapPoint u{b.x - a.x, b.y - a.y, b.z - a.z};
  const MapPoint v{c.x - a.x, c.y - a.y, c.z - a.z};
  const float twice_area = u.x * v.y - u.y * v.x;
  if (twice_area == 0) return;
  const bool turns_left = twice_area > 0;
  const Plane first = turns_left ? left_of(origin, u) : left_of(u, origin);
  const Plane second = turns_left ? left_of(u, v) : left_of(v, u);
  const Plane third = turns_left ? left_of(v, origin) : left_of(origin, v);
  const Plane depth{a.z, (u.z * v.y - v.z * u.y) / twice_area, (v.z * u.x - u.z * v.x) / twice_area};
  const float shift = kSlopeShift * std::max(std::abs(depth.dx), std::abs(depth.dy));
  const float nearest = std::min({a.z, b.z, c.z});
  for (int row = top; row < bottom; ++row) {
    const float y = static_cast<float>(row) + 0.5f - a.y;
    for (int column = left; column < right; ++column) {
      const float x = static_cast<float>(column) + 0.5f - a.x;
      if (std::min({first(x, y), second(x, y), third(x, y)}) < 0) continue;
      map.put(column, row, std::max(depth(x, y), nearest) + shift);
    }
  }
}

void draw_point(const Map& map, const MapPoint& p, float radius) {
  const int right = std::max(map.end(p.x + radius), std::clamp(static_cast<int>(p.x), 0, map.size - 1) + 1);
  const int bottom = std::max(map.end(p.y + radius), std::clamp(static_cast<int>(p.y), 0, map.size - 1) + 1);
  for (int y = std::min(map.first(p.y - radius), bottom - 1); y < bottom; ++y) {
    for (int x = std::min(map.first(p.x - radius), right - 1); x < right; ++x) map.put(x, y, p.z);
  }
}

void draw_map(const Occluder& occluder, const LightMatrix& light, const Map& map, double point_radius) {
  const auto size = static_cast<float>(map.size);
  std::vector<MapPoint> places(occluder.positions.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = place(light, occluder.positions[i], size);
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    draw_triangle(map, places[occluder.indices[i]], places[occluder.indices[i + 1]], places[occluder.indices[i + 2]]);
  }
  const auto radius = static_cast<float>(0.5 * point_radius / occluder.radius * map.size);
  for (const Vec3f& p : occluder.points) draw_point(map, place(light, p, size), radius);
}

}  // namespace

std::vector<std::uint16_t> draw_shadow_maps(const Occluder& occluder, std::span<const LightMatrix> lights, int size,
                                            double point_radius) {
  const std::size_t texels = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  std::vector<std::uint16_t> depths(texels * lights.size(), static_cast<std::uint16_t>(kFarthest));
  parallel_for(lights.size(), 1, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      draw_map(occluder, lights[i], {size, depths.data() + i * texels}, point_radius);
    }
  });
  return depths;
}

}  // namespace knead::render
