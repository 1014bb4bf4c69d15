// The build with knead::render.
#include "picture.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "command.h"
#include "knead/render.h"
#include "knead/vec.h"

namespace knead::command {
namespace {

using render::Image;
using render::Scene;

std::vector<Scene> scenes_of(const PictureRequest& request) {
  std::vector<Scene> scenes(request.panels.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Panel& panel = request.panels[i];
    render::Shape& shape = scenes[i].shapes.emplace_back();
    shape.mesh = &panel.shape;
    shape.use_mesh_colors = true;
    const Box box = render::shapes_box(scenes[i]);
    for (const render::DrawnTool& tool : panel.tools) render::draw_tool(tool, box, scenes[i]);
    if (request.cut) scenes[i].clip = {.normal = request.cut->normal, .offset = request.cut->offset};
  }
  return scenes;
}

// The camera of fit_camera moved sideways and in or out.
render::Camera close_up_camera(const render::Camera& fitted, const CloseUp& close_up) {
  render::Camera camera = fitted;
  camera.target = close_up.target;
  camera.eye = close_up.target + (fitted.eye - fitted.target) * (close_up.height / fitted.height);
  camera.height = close_up.height;
  return camera;
}

render::Camera fitted(const PictureRequest& request, const std::vector<Vec3d>& points, double aspect) {
  render::FitOptions how;
  if (request.field_of_view_deg == 0) how.projection = render::Projection::orthographic;
  how.field_of_view_deg = request.field_of_view_deg;
  return render::fit_points(points, request.view, request.up, aspect, how);
}

// The points of each scene, each about the middle of its own box, so that one camera is right for all.
void set_cameras_of_one_scale(const PictureRequest& request, double aspect, std::vector<Scene>& scenes) {
  std::vector<Vec3d> points;
  std::vector<Vec3d> middles;
  for (const Scene& scene : scenes) {
    const Box box = render::scene_box(scene);
    middles.push_back(box.empty() ? Vec3d{} : box.center());
    for (const Vec3d& p : render::scene_points(scene)) points.push_back(p - middles.back());
  }
  const render::Camera camera = fitted(request, points, aspect);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    scenes[i].camera = camera;
    scenes[i].camera.eye += middles[i];
    scenes[i].camera.target += middles[i];
  }
}

void set_cameras(const PictureRequest& request, double aspect, std::vector<Scene>& scenes) {
  if (request.same_scale) return set_cameras_of_one_scale(request, aspect, scenes);
  std::vector<Vec3d> points = request.shown;
  for (const Scene& scene : scenes) {
    if (!request.shown.empty()) break;
    const std::vector<Vec3d> own = render::scene_points(scene);
    points.insert(points.end(), own.begin(), own.end());
  }
  render::Camera camera = fitted(request, points, aspect);
  if (request.close_up) camera = close_up_camera(camera, *request.close_up);
  for (Scene& scene : scenes) scene.camera = camera;
}

render::Options options_of(const PictureRequest& request) {
  render::Options options;
  options.height = request.height;
  options.background = request.background.top;
  options.background_bottom = request.background.bottom;
  options.matcap = request.matcap;
  options.relief = request.relief;
  switch (request.quality) {
    case PictureQuality::draft:
      options.supersampling = 1;
      options.light_samples = 32;
      break;
    case PictureQuality::normal:
      break;
    case PictureQuality::fine:
      options.supersampling = 3;
      options.light_samples = 256;
      break;
  }
  options.shading = request.flat ? render::Shading::flat : render::Shading::smooth;
  options.wireframe = request.wireframe;
  options.ground = request.ground;
  return options;
}

}  // namespace

void require_renderer() {}

std::string material_names() {
  std::string names = "clay";
  for (const render::Matcap matcap : render::all_matcaps()) names += ", " + std::string(name_of(matcap));
  return names;
}

std::optional<render::Matcap> read_material(const std::string& name) {
  const std::optional<render::Matcap> matcap = render::matcap_named(name);
  if (!matcap && name != "clay") throw UsageError("--material " + name + ": say one of " + material_names());
  return matcap;
}

render::Background read_background(const std::string& name) {
  if (name == "white") return {{1, 1, 1, 1}, {1, 1, 1, 1}};
  if (name == "transparent") return {{1, 1, 1, 0}, {1, 1, 1, 0}};
  if (const auto background = render::background_named(name)) return *background;
  throw UsageError("--background " + name + ": say white, transparent, light, dark, gradient, or a colour as #303540");
}

render::Image draw_image(const PictureRequest& request, const std::function<void(double)>& progress) {
  std::vector<Scene> scenes = scenes_of(request);
  const int count = static_cast<int>(scenes.size());
  const int width = request.width / count;
  set_cameras(request, static_cast<double>(width) / request.height, scenes);
  render::Options options = options_of(request);
  std::vector<Image> images;
  for (int i = 0; i < count; ++i) {
    options.width = width + (i < request.width % count ? 1 : 0);
    options.progress = [&, i](double part) { progress((i + part) / count); };
    images.push_back(render::render(scenes[static_cast<std::size_t>(i)], options));
  }
  return render::side_by_side(images);
}

std::string draw_picture(const PictureRequest& request, const std::function<void(double)>& progress) {
  const Image picture = draw_image(request, progress);
  return request.format == ImageFormat::jpeg ? render::encode_jpeg(picture) : render::encode_png(picture);
}

std::vector<Vec3d> outermost_points(std::span<const Vec3d> positions) {
  constexpr int directions = 64;  // evenly over the sphere, on a spiral
  std::vector<Vec3d> points;
  for (int k = 0; k < directions && !positions.empty(); ++k) {
    const double z = 1 - (2 * k + 1.0) / directions;
    const double angle = 2.399963 * k;  // the golden angle
    const double r = std::sqrt(1 - z * z);
    const Vec3d direction{r * std::cos(angle), z, r * std::sin(angle)};
    points.push_back(*std::max_element(positions.begin(), positions.end(), [&](const Vec3d& a, const Vec3d& b) {
      return dot(a, direction) < dot(b, direction);
    }));
  }
  return points;
}

}  // namespace knead::command
