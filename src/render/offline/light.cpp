// Rods, glass in layers, and shadow maps.
#include <algorithm>
#include <cmath>

#include "knead/error.h"
#include "math/system.h"
#include "render/offline/passes.h"

namespace knead::render {
namespace {

constexpr std::size_t kMaxLayers = 16;
constexpr double kLineWidth = 1.6;  // in pixels, of the line where glass meets a shape

// Draws the layer behind `before` into the bound framebuffer; returns whether there was one.
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

constexpr float kFarthest = 65535;
constexpr float kSlopeShift = 1.5f;

// In texels across, and in steps of depth.
struct MapPoint {
  float x;
  float y;
  float z;
};

constexpr int kRun = 4;  // texels that are tested together; rows are longer than the map by them

struct Map {
  int size;
  float* depths;

  float* row(int y) const { return depths + static_cast<std::ptrdiff_t>(y) * (size + kRun); }

  // The texels whose centres lie in [from, to]: first and one past the last. Without calls of ceil() and floor().
  int first(float from) const {
    const float at = std::max(from, -1.0f) - 0.5f;
    const int below = static_cast<int>(at);
    return std::max(0, below + (static_cast<float>(below) < at ? 1 : 0));
  }
  int end(float to) const {
    const float at = std::max(std::min(to, static_cast<float>(size)), -1.0f) - 0.5f;
    const int above = static_cast<int>(at);
    return std::min(size, above + (static_cast<float>(above) > at ? 0 : 1));
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

// At least 0 on the left of the line from a to b.
Plane left_of(const MapPoint& a, const MapPoint& b) {
  const float dx = b.x - a.x;
  const float dy = b.y - a.y;
  return {dy * a.x - dx * a.y, -dy, dx};
}

// Tests each texel of the box around a triangle, a run of them at once: most triangles are a few texels large.
void draw_triangle(const Map& map, const MapPoint& a, const MapPoint& b, const MapPoint& c, bool has_back) {
  // From a, so that the numbers are small.
  const MapPoint origin{0, 0, 0};
  const MapPoint u{b.x - a.x, b.y - a.y, b.z - a.z};
  const MapPoint v{c.x - a.x, c.y - a.y, c.z - a.z};
  const float twice_area = u.x * v.y - u.y * v.x;
  const bool turns_left = twice_area > 0;
  if (has_back ? twice_area == 0 : !turns_left) return;
  const int top = map.first(std::min(std::min(a.y, b.y), c.y));
  const int bottom = map.end(std::max(std::max(a.y, b.y), c.y));
  const int left = map.first(std::min(std::min(a.x, b.x), c.x));
  const int right = map.end(std::max(std::max(a.x, b.x), c.x));
  if (top >= bottom || left >= right) return;
  const Plane first = turns_left ? left_of(origin, u) : left_of(u, origin);
  const Plane second = turns_left ? left_of(u, v) : left_of(v, u);
  const Plane third = turns_left ? left_of(v, origin) : left_of(origin, v);
  const Plane depth{a.z, (u.z * v.y - v.z * u.y) / twice_area, (v.z * u.x - u.z * v.x) / twice_area};
  const float shift = kSlopeShift * std::max(std::abs(depth.dx), std::abs(depth.dy));
  const float nearest = std::min(std::min(a.z, b.z), c.z);
  const int columns = (right - left + kRun - 1) / kRun * kRun;
  for (int row = top; row < bottom; ++row) {
    const float y = static_cast<float>(row) + 0.5f - a.y;
    float* const depths = map.row(row) + left;
    for (int k = 0; k < columns; ++k) {
      const float x = static_cast<float>(left + k) + 0.5f - a.x;
      // No branches, because they would be unpredictable.
      const float inside = std::min(std::min(first(x, y), second(x, y)), third(x, y));
      const float z = std::max(std::max(depth(x, y), nearest) + shift, 0.0f);
      const float drawn = std::min(depths[k], z);
      depths[k] = inside >= 0 ? drawn : depths[k];
    }
  }
}

void draw_point(const Map& map, const MapPoint& p, float radius) {
  const int right = std::max(map.end(p.x + radius), std::clamp(static_cast<int>(p.x), 0, map.size - 1) + 1);
  const int bottom = std::max(map.end(p.y + radius), std::clamp(static_cast<int>(p.y), 0, map.size - 1) + 1);
  for (int y = std::min(map.first(p.y - radius), bottom - 1); y < bottom; ++y) {
    for (int x = std::min(map.first(p.x - radius), right - 1); x < right; ++x) {
      float& depth = map.row(y)[x];
      depth = std::min(depth, std::max(p.z, 0.0f));
    }
  }
}

void draw_map(const Occluder& occluder, const LightMatrix& light, const Map& map, double point_radius) {
  const auto size = static_cast<float>(map.size);
  std::vector<MapPoint> places(occluder.positions.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = place(light, occluder.positions[i], size);
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    draw_triangle(map, places[occluder.indices[i]], places[occluder.indices[i + 1]], places[occluder.indices[i + 2]],
                  !occluder.is_solid);
  }
  const auto radius = static_cast<float>(0.5 * point_radius / occluder.radius * map.size);
  for (const Vec3f& p : occluder.points) draw_point(map, place(light, p, size), radius);
}

KNEAD_CLONES void round_all(const float* depths, std::span<std::uint16_t> rounded) {
  for (std::size_t i = 0; i < rounded.size(); ++i) rounded[i] = static_cast<std::uint16_t>(depths[i]);
}

}  // namespace

void draw_rods(const Pass& pass, const GBuffer& buffer, const gl::Texture& color, const SurfaceBuffers& rods) {
  if (rods.count == 0) return;
  const gl::Framebuffer target = gl::make_framebuffer({&color, &buffer.normal}, &buffer.depth);
  reset_state(pass);
  const gl::Program& program = pass.programs.rod;
  use(program, pass);
  set_simple_light(program, pass.view);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  // First the hidden parts, faintly; then the visible ones.
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

void draw_glass(const Pass& pass, const GBuffer& buffer, const gl::Texture& color,
                const std::vector<SurfaceBuffers>& surfaces) {
  if (surfaces.empty()) return;
  const gl::Texture over = make_texture(pass, GL_RGBA16F);
  const gl::Framebuffer over_target = gl::make_framebuffer({&over}, nullptr);
  clear(0, 0, 0, 0);
  const gl::Texture layer = make_texture(pass, GL_RGBA16F);
  const gl::Texture depths[2] = {make_texture(pass, GL_DEPTH_COMPONENT32F), make_texture(pass, GL_DEPTH_COMPONENT32F)};
  const gl::Framebuffer targets[2] = {gl::make_framebuffer({&layer}, &depths[0]),
                                      gl::make_framebuffer({&layer}, &depths[1])};
  reset_state(pass);
  glClearDepth(0);
  glClear(GL_DEPTH_BUFFER_BIT);  // depths[1]: nothing is drawn yet
  for (std::size_t i = 0; i < kMaxLayers; ++i) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets[i % 2].get());
    reset_state(pass);
    if (!draw_layer(pass, buffer, surfaces, depths[1 - i % 2])) break;
    glBindFramebuffer(GL_FRAMEBUFFER, over_target.get());
    reset_state(pass);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    copy(pass, layer);
  }
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  reset_state(pass);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  copy(pass, over);
}

void draw_shadow_maps(const Occluder& occluder, std::span<const LightMatrix> lights, int size, double point_radius,
                      std::span<std::uint16_t> maps) {
  const auto texels = static_cast<std::size_t>(size);
  parallel_for(lights.size(), 1, 0, [&](std::size_t begin, std::size_t end) {
    std::vector<float> drawn(static_cast<std::size_t>(size + kRun) * static_cast<std::size_t>(size));
    for (std::size_t i = begin; i < end; ++i) {
      const Map map{size, drawn.data()};
      std::fill(drawn.begin(), drawn.end(), kFarthest);
      draw_map(occluder, lights[i], map, point_radius);
      for (int y = 0; y < size; ++y) round_all(map.row(y), maps.subspan(i * texels * texels + y * texels, texels));
    }
  });
}

}  // namespace knead::render
