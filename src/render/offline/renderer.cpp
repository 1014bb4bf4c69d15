// The offline renderer: the order of its passes, and the part of the picture that they draw.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/error.h"
#include "render/offline/passes.h"
#include "render/surface.h"

namespace knead::render {

namespace {

// Closes the drawn shapes where the clipping plane has opened them.
void draw_cuts(const Pass& pass, const std::vector<SurfaceBuffers>& shapes, const gl::Framebuffer& target) {
  const gl::Texture nearest = make_texture(pass, GL_DEPTH_COMPONENT32F);
  const gl::Framebuffer copy = gl::make_framebuffer({}, &nearest);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.get());
  const Part& part = pass.part;
  glBlitFramebuffer(0, 0, part.width, part.height, 0, 0, part.width, part.height, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  const gl::Program& program = pass.programs.cap;
  use_clipped(program, pass);
  bind_texture(program, "nearest_map", 0, GL_TEXTURE_2D, nearest);
  set(program, "cut_srgb", pass.cut);
  for (const SurfaceBuffers& shape : shapes) {
    if (!shape.points) draw(shape);
  }
}

// Draws a large picture in parts, so that its progress function can stop it soon.
void draw_in_parts(const Pass& pass, const SurfaceBuffers& surface) {
  constexpr GLsizei corners = 3 << 17;
  const bool in_parts = pass.options.progress && pass.width * pass.height > 1 << 23;
  for (GLsizei first = 0; first < surface.count; first += corners) {
    draw(surface, first, in_parts ? std::min(corners, surface.count - first) : surface.count);
    if (!in_parts) return;
    report(pass, *pass.reported);
  }
}

// Draws fronts first, which hide most backs, so that these are not shaded, which is slow without a GPU.
void draw_faces(const Pass& pass, const SurfaceBuffers& surface) {
  glEnable(GL_CULL_FACE);
  glCullFace(GL_BACK);
  draw_in_parts(pass, surface);
  glCullFace(GL_FRONT);
  draw_in_parts(pass, surface);
  glDisable(GL_CULL_FACE);
}

template <class T>
std::unique_ptr<T[]> read_back(const Pass& pass, GLenum attachment, GLenum format, GLenum type) {
  const std::size_t count = static_cast<std::size_t>(pass.part.width) * static_cast<std::size_t>(pass.part.height);
  std::unique_ptr<T[]> values(new T[count]);
  if (attachment != GL_DEPTH_ATTACHMENT) glReadBuffer(attachment);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, pass.part.width, pass.part.height, format, type, values.get());
  return values;
}

Samples read_samples(const Pass& pass, const GBuffer& buffer) {
  const gl::Framebuffer source = gl::make_framebuffer({&buffer.reflectance, &buffer.normal}, &buffer.depth);
  return {read_back<float>(pass, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT, GL_FLOAT),
          read_back<Bytes4>(pass, GL_COLOR_ATTACHMENT0, GL_RGBA, GL_UNSIGNED_BYTE),
          read_back<Shorts4>(pass, GL_COLOR_ATTACHMENT1, GL_RGBA, GL_UNSIGNED_SHORT), nullptr};
}

// Returns rods and glass, which are in front of the shapes.
std::unique_ptr<Shorts4[]> draw_front(const Pass& pass, const GBuffer& buffer, const SurfaceBuffers& rods,
                                      const std::vector<SurfaceBuffers>& glass) {
  if (rods.count == 0 && glass.empty()) return nullptr;
  const gl::Texture color = make_texture(pass, GL_RGBA16F);
  const gl::Framebuffer target = gl::make_framebuffer({&color}, nullptr);
  reset_state(pass);
  clear(0, 0, 0, 0);
  draw_rods(pass, buffer, color, rods);
  draw_glass(pass, buffer, color, glass);
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  return read_back<Shorts4>(pass, GL_COLOR_ATTACHMENT0, GL_RGBA, GL_UNSIGNED_SHORT);
}

void check(const Options& options) {
  if (options.supersampling < 1 || options.supersampling > kMaxSupersampling || options.light_samples < 16 ||
      options.light_samples > 1024) {
    throw InvalidInput("render: options out of range; give 1 to 4 for supersampling, 16 to 1024 for light_samples");
  }
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (options.width < 1 || options.height < 1 || options.width > largest / options.supersampling ||
      options.height > largest / options.supersampling) {
    throw InvalidInput("render: a picture of " + std::to_string(options.width) + " x " +
                       std::to_string(options.height) + " pixels; give 1 to " +
                       std::to_string(largest / options.supersampling) + " along each side");
  }
}

double automatic_point_radius(const std::vector<DrawSurface>& surfaces) {
  std::size_t count = 0;
  for (const DrawSurface& surface : surfaces) count += surface.indices.empty() ? surface.vertices.size() : 0;
  return std::clamp(0.9 / std::sqrt(static_cast<double>(std::max<std::size_t>(count, 1))), 0.003, 0.04);
}

std::vector<DrawSurface> shape_surfaces(const Scene& scene, const Placement& placement, const Options& options) {
  const double crease = options.crease_angle_deg * std::numbers::pi / 180;
  const SurfaceOptions how{options.shading == Shading::flat ? -1 : std::max(0.0, crease), options.wireframe};
  std::vector<DrawSurface> surfaces;
  for (const Shape& shape : scene.shapes) {
    if (shape.mesh != nullptr) surfaces.push_back(make_surface(*shape.mesh, colors_of(shape), placement, how));
  }
  return surfaces;
}

std::vector<SurfaceBuffers> upload_shapes(const Scene& scene, const std::vector<DrawSurface>& surfaces,
                                          double point_radius) {
  std::vector<SurfaceBuffers> shapes;
  for (const Shape& shape : scene.shapes) {
    if (shape.mesh == nullptr) continue;
    shapes.push_back(upload(surfaces[shapes.size()]));
    shapes.back().color = shape.back_color;
    shapes.back().point_radius = point_radius;
  }
  return shapes;
}

std::vector<DrawSurface> glass_surfaces(const Scene& scene, const Placement& placement) {
  std::vector<DrawSurface> surfaces;
  for (const TranslucentSurface& surface : scene.surfaces) {
    surfaces.push_back(make_surface(surface.mesh, {}, placement, {}));
  }
  return surfaces;
}

std::vector<SurfaceBuffers> upload_glass(const Scene& scene, const std::vector<DrawSurface>& glass) {
  std::vector<SurfaceBuffers> surfaces;
  for (std::size_t i = 0; i < glass.size(); ++i) {
    if (glass[i].indices.empty()) continue;
    surfaces.push_back(upload(glass[i]));
    surfaces.back().color = scene.surfaces[i].color;
  }
  return surfaces;
}

DrawSurface rod_surface(const Scene& scene, const Placement& placement) {
  DrawSurface rods;
  for (const Arrow& arrow : scene.arrows) add_arrow(arrow, placement, rods);
  for (const Line& line : scene.lines) add_line(line, placement, rods);
  return rods;
}

// The part of the picture that vertices touch, growing with them.
class PartFinder {
 public:
  PartFinder(const Pass& pass, double point_radius)
      : pass_(pass), point_radius_(static_cast<float>(point_radius / pass.view.pixel)) {}

  void add(const DrawSurface& surface) {
    const Mat4f& m = pass_.view.matrix;
    for (const DrawVertex& vertex : surface.vertices) {
      const Vec3f& p = vertex.position;
      const auto row = [&](std::size_t k) { return m[k] * p.x + m[4 + k] * p.y + m[8 + k] * p.z + m[12 + k]; };
      const float w = row(3);
      if (!(w > 0)) sees_behind_ = true;
      const float reach = 2 + (surface.indices.empty() ? point_radius_ / w : 0);
      const float x = (0.5F + 0.5F * row(0) / w) * static_cast<float>(pass_.width);
      const float y = (0.5F + 0.5F * row(1) / w) * static_cast<float>(pass_.height);
      left_ = std::min(left_, x - reach);
      right_ = std::max(right_, x + reach);
      bottom_ = std::min(bottom_, y - reach);
      top_ = std::max(top_, y + reach);
    }
  }

  // Whole pixels, at least one; the whole picture if a vertex lies behind the eye.
  Part part() const {
    if (sees_behind_) return {0, 0, pass_.width, pass_.height};
    const int factor = pass_.options.supersampling;
    const auto first = [&](float x, int size) {
      return static_cast<int>(std::clamp(x, 0.0F, static_cast<float>(size - factor))) / factor * factor;
    };
    const auto count = [&](int from, float to, int size) {
      const int samples = static_cast<int>(std::clamp(to, 0.0F, static_cast<float>(size - 1))) / factor * factor - from;
      return std::max(samples, 0) + factor;
    };
    const int left = first(left_, pass_.width);
    const int bottom = first(bottom_, pass_.height);
    return {left, bottom, count(left, right_, pass_.width), count(bottom, top_, pass_.height)};
  }

 private:
  const Pass& pass_;
  float point_radius_;
  bool sees_behind_ = false;
  float left_ = std::numeric_limits<float>::max();
  float bottom_ = left_;
  float right_ = -left_;
  float top_ = -left_;
};

void set_clip(const Scene& scene, Pass& pass) {
  if (!scene.clip) return;
  const double length = norm(scene.clip->normal);
  if (!(length > 0) || !std::isfinite(length)) {
    throw InvalidInput("render: the clipping plane has no normal; give one that is not zero");
  }
  const Placement& placement = pass.view.placement;
  const Vec3f normal(scene.clip->normal / length);
  const double offset = (scene.clip->offset - dot(scene.clip->normal, placement.center)) * placement.scale / length;
  pass.clip = {normal.x, normal.y, normal.z, static_cast<float>(offset)};
  pass.clipped = true;
  pass.cut = scene.clip->color;
}

// Binds the default framebuffer at the end.
struct FramebufferGuard {
  FramebufferGuard() = default;
  FramebufferGuard(const FramebufferGuard&) = delete;
  FramebufferGuard& operator=(const FramebufferGuard&) = delete;
  ~FramebufferGuard() { glBindFramebuffer(GL_FRAMEBUFFER, 0); }
};

}  // namespace

GBuffer draw_shapes(const Pass& pass, const std::vector<SurfaceBuffers>& shapes) {
  GBuffer buffer{make_texture(pass, GL_DEPTH_COMPONENT32F), make_texture(pass, GL_RGBA8),
                 make_texture(pass, GL_RGBA16)};
  const gl::Framebuffer target = gl::make_framebuffer({&buffer.reflectance, &buffer.normal}, &buffer.depth);
  reset_state(pass);
  glEnable(GL_DEPTH_TEST);
  clear(0, 0, 0, 0);
  clear_depth();
  for (const SurfaceBuffers& shape : shapes) {
    const gl::Program& clay = pass.options.wireframe ? pass.programs.wired : pass.programs.clay;
    const gl::Program& program = shape.points ? pass.programs.disc : clay;
    use_clipped(program, pass);
    set(program, "back_srgb", shape.color);
    set(program, "wire_width", 1.1 * pass.options.supersampling);
    set(program, "point_size", 2 * shape.point_radius / pass.view.pixel);
    shape.points ? draw_in_parts(pass, shape) : draw_faces(pass, shape);
  }
  if (pass.clipped) draw_cuts(pass, shapes, target);
  return buffer;
}

Renderer::Renderer() {
  gl::require_version(33);
  programs_ = std::make_unique<Programs>();
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Image Renderer::render(const Scene& scene, const Options& options) {
  // Occluders finer than this are drawn coarser; the cell is four texels of a shadow map.
  constexpr std::size_t max_occluders = 150'000;
  check(options);
  const int width = options.width * options.supersampling;
  const int height = options.height * options.supersampling;
  const View view = make_view(scene, static_cast<double>(width) / height, height);
  double reported = 0;
  Pass pass{*programs_, view, options, width, height, {}};
  pass.reported = &reported;
  set_clip(scene, pass);

  const std::vector<DrawSurface> surfaces = shape_surfaces(scene, view.placement, options);
  const std::vector<DrawSurface> glass = glass_surfaces(scene, view.placement);
  const DrawSurface rods = rod_surface(scene, view.placement);
  const double point_radius =
      options.point_radius > 0 ? options.point_radius * view.placement.scale : automatic_point_radius(surfaces);
  PartFinder finder(pass, point_radius);
  for (const DrawSurface& surface : surfaces) finder.add(surface);
  for (const DrawSurface& surface : glass) finder.add(surface);
  finder.add(rods);
  pass.part = finder.part();
  Lighting lighting{studio_lights(view, options.light_samples),
                    make_occluder(surfaces, view.ground_up, 8.0 / kShadowMapSize, max_occluders, point_radius),
                    point_radius};
  if (pass.clipped) clip_occluder(lighting.occluder, pass.clip);
  report(pass, 0.15);

  const FramebufferGuard guard;
  const GBuffer buffer = draw_shapes(pass, upload_shapes(scene, surfaces, point_radius));
  Samples samples = read_samples(pass, buffer);
  samples.front = draw_front(pass, buffer, upload(rods), upload_glass(scene, glass));
  report(pass, 0.3);
  Image image = shade(pass, samples, lighting);
  report(pass, 1);
  return image;
}

Image render(const Scene& scene, const Options& options) {
  const gl::OffscreenContext context;
  return Renderer().render(scene, options);
}

}  // namespace knead::render
