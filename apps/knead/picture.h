// What `knead render` draws, as plain values that need no renderer.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/mesh.h"
#include "knead/render.h"
#include "knead/vec.h"

namespace knead::command {

struct Panel {
  Mesh shape;
  std::vector<render::DrawnTool> tools;
};

// Removes the side dot(normal, x) > offset of every shape.
struct CutPlane {
  Vec3d normal;
  double offset = 0;
};

// The point that the camera looks at, and the height of the picture there.
struct CloseUp {
  Vec3d target;
  double height = 0;
};

enum class ImageFormat { png, jpeg };

// How many samples a pixel has, and from how many directions light comes.
enum class PictureQuality { draft, normal, fine };

struct PictureRequest {
  std::vector<Panel> panels;  // side by side, at least one
  std::optional<CutPlane> cut;
  std::optional<CloseUp> close_up;  // empty: shows everything
  std::vector<Vec3d> shown;         // the points that the camera shows; empty: those of the panels
  Vec3d view{0, 0, -1};             // into the scene
  Vec3d up{0, 1, 0};
  int width = 1600;  // of the whole picture
  int height = 1200;
  double field_of_view_deg = 25;                              // from bottom to top; 0: orthographic
  render::Background background{{1, 1, 1, 1}, {1, 1, 1, 1}};  // alpha 0: transparent
  std::optional<render::Matcap> matcap;                       // empty: clay under the studio's light
  render::Relief relief;
  PictureQuality quality = PictureQuality::normal;
  bool ground = true;  // the shadow on the ground
  bool flat = false;   // one normal per face
  bool wireframe = false;
  bool same_scale = false;  // each shape is centred in its panel, all at one scale
  ImageFormat format = ImageFormat::png;
};

// Return what the names of a material and a background mean. Throw UsageError for unknown names. A build without a
// renderer knows none and lets all pass.
std::optional<render::Matcap> read_material(const std::string& name);
render::Background read_background(const std::string& name);

// Returns the names of all materials, separated by commas.
std::string material_names();

// Throws std::runtime_error in a build without a renderer.
void require_renderer();

// Returns the picture. progress: called with the part that is done, from 0 to 1. Throws as
// require_renderer, and if the machine has no OpenGL 3.3.
render::Image draw_image(const PictureRequest& request, const std::function<void(double)>& progress);

// Returns the bytes of an image file.
std::string draw_picture(const PictureRequest& request, const std::function<void(double)>& progress);

// Returns points of a shape that are the farthest in many directions, for PictureRequest::shown.
std::vector<Vec3d> outermost_points(std::span<const Vec3d> positions);

}  // namespace knead::command
