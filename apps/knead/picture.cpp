// The build with knead::render.
#include "picture.h"

#include <algorithm>

#include "knead/math/box.h"
#include "knead/render/camera.h"
#include "knead/render/image.h"
#include "knead/render/renderer.h"
#include "knead/render/scene.h"
#include "knead/render/tool_picture.h"

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

// All shapes at the middle of `box`, which then has their largest extents.
Box common_box(const std::vector<Scene>& scenes) {
  Vec3d size{0, 0, 0};
  for (const Scene& scene : scenes) {
    const Box box = render::scene_box(scene);
    if (box.empty()) continue;
    const Vec3d extent = box.max - box.min;
    size = {std::max(size.x, extent.x), std::max(size.y, extent.y), std::max(size.z, extent.z)};
  }
  Box box;
  box.extend(size * -0.5);
  box.extend(size * 0.5);
  return box;
}

// The camera of fit_camera moved sideways and in or out.
render::Camera close_up_camera(const render::Camera& fitted, const CloseUp& close_up) {
  render::Camera camera = fitted;
  camera.target = close_up.target;
  camera.eye = close_up.target + (fitted.eye - fitted.target) * (close_up.height / fitted.height);
  camera.height = close_up.height;
  return camera;
}

void set_cameras(const PictureRequest& request, double aspect, std::vector<Scene>& scenes) {
  if (request.same_scale) {
    const render::Camera camera = render::fit_camera(common_box(scenes), request.view, request.up, aspect);
    for (Scene& scene : scenes) {
      const Box box = render::scene_box(scene);
      const Vec3d middle = box.empty() ? Vec3d{} : box.center();
      scene.camera = camera;
      scene.camera.eye += middle;
      scene.camera.target += middle;
    }
    return;
  }
  Box all;
  for (const Scene& scene : scenes) {
    const Box box = render::scene_box(scene);
    if (box.empty()) continue;
    all.extend(box.min);
    all.extend(box.max);
  }
  render::Camera camera = render::fit_camera(all, request.view, request.up, aspect);
  if (request.close_up) camera = close_up_camera(camera, *request.close_up);
  for (Scene& scene : scenes) scene.camera = camera;
}

render::Options options_of(const PictureRequest& request) {
  render::Options options;
  options.height = request.height;
  if (request.transparent) options.background = {1, 1, 1, 0};
  options.shading = request.flat ? render::Shading::flat : render::Shading::smooth;
  options.wireframe = request.wireframe;
  options.ground = request.ground;
  return options;
}

}  // namespace

void require_renderer() {}

std::string draw_picture(const PictureRequest& request) {
  std::vector<Scene> scenes = scenes_of(request);
  const int count = static_cast<int>(scenes.size());
  const int width = request.width / count;
  set_cameras(request, static_cast<double>(width) / request.height, scenes);
  render::Options options = options_of(request);
  std::vector<Image> images;
  for (int i = 0; i < count; ++i) {
    options.width = width + (i < request.width % count ? 1 : 0);
    images.push_back(render::render(scenes[static_cast<std::size_t>(i)], options));
  }
  const Image picture = render::side_by_side(images);
  return request.format == ImageFormat::jpeg ? render::encode_jpeg(picture) : render::encode_png(picture);
}

}  // namespace knead::command
