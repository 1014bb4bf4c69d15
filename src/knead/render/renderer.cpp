#include "knead/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/gl/context.h"
#include "knead/math/error.h"
#include "knead/render/passes.h"
#include "knead/render/rods.h"
#include "knead/render/shaders.h"

namespace knead::render {
namespace {

void check(const Options& options) {
  if (options.supersampling < 1 || options.supersampling > 4 || options.light_samples < 16 ||
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

std::vector<SurfaceBuffers> upload_glass(const Scene& scene, const Placement& placement) {
  std::vector<SurfaceBuffers> surfaces;
  for (const TranslucentSurface& surface : scene.surfaces) {
    if (surface.mesh.face_count() == 0) continue;
    surfaces.push_back(upload(make_surface(surface.mesh, {}, placement, {})));
    surfaces.back().color = surface.color;
  }
  return surfaces;
}

SurfaceBuffers upload_rods(const Scene& scene, const Placement& placement) {
  DrawSurface rods;
  for (const Arrow& arrow : scene.arrows) add_arrow(arrow, placement, rods);
  for (const Line& line : scene.lines) add_line(line, placement, rods);
  SurfaceBuffers result = upload(rods);
  if (rods.indices.empty()) result.count = 0;
  return result;
}

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

}  // namespace

bool lights_ground(const Light& light, const Vec3d& up) { return dot(Vec3d(light.direction), up) > kGrazingCosine; }

namespace {

double unshadowed_light(const std::vector<Light>& lights, const Vec3d& up) {
  double sum = 0;
  for (const Light& light : lights) {
    const double luminance = dot(Vec3d(light.radiance), Vec3d{0.3, 0.6, 0.1});
    const double cosine = std::max(0.0, dot(Vec3d(light.direction), up) - kGrazingCosine);
    sum += cosine * cosine * luminance;
  }
  return sum;
}

// Leaves the default framebuffer bound, whatever happens.
struct FramebufferGuard {
  FramebufferGuard() = default;
  FramebufferGuard(const FramebufferGuard&) = delete;
  FramebufferGuard& operator=(const FramebufferGuard&) = delete;
  ~FramebufferGuard() { glBindFramebuffer(GL_FRAMEBUFFER, 0); }
};

}  // namespace

Renderer::Renderer() {
  gl::require_version(33);
  programs_ = std::make_unique<Programs>();
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Image Renderer::render(const Scene& scene, const Options& options) {
  // Occluders finer than this are drawn coarser; the cell is two texels of a shadow map.
  constexpr std::size_t most_occluders = 150'000;
  check(options);
  const int width = options.width * options.supersampling;
  const int height = options.height * options.supersampling;
  const View view = make_view(scene, static_cast<double>(width) / height, height);
  Pass pass{*programs_, view, options, width, height};
  set_clip(scene, pass);

  const std::vector<DrawSurface> surfaces = shape_surfaces(scene, view.placement, options);
  const double point_radius =
      options.point_radius > 0 ? options.point_radius * view.placement.scale : automatic_point_radius(surfaces);
  Lighting lighting{studio_lights(view, options.light_samples),
                    make_occluder(surfaces, view.ground_up, 4.0 / kShadowMapSize, most_occluders), point_radius};
  std::stable_partition(lighting.lights.begin(), lighting.lights.end(),
                        [&](const Light& light) { return lights_ground(light, view.ground_up); });
  lighting.ground_light = unshadowed_light(lighting.lights, view.ground_up);
  if (pass.clipped) clip_occluder(lighting.occluder, pass.clip);
  report(pass, 0.15);

  const FramebufferGuard guard;
  const GBuffer buffer = draw_shapes(pass, upload_shapes(scene, surfaces, point_radius));
  report(pass, 0.25);
  const LightMaps light = draw_light(pass, buffer, lighting);
  const gl::Texture color = draw_backdrop(pass, buffer, light, lighting);
  draw_rods(pass, buffer, color, upload_rods(scene, view.placement));
  draw_glass(pass, buffer, color, upload_glass(scene, view.placement));
  Image image = resolve(pass, color);
  report(pass, 1);
  return image;
}

Image render(const Scene& scene, const Options& options) {
  const gl::OffscreenContext context;
  return Renderer().render(scene, options);
}

}  // namespace knead::render
