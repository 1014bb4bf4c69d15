// What `knead render` draws, as plain values that need no renderer.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/math/vec3.h"
#include "knead/mesh/mesh.h"
#include "knead/render/tool_picture.h"

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

struct PictureRequest {
  std::vector<Panel> panels;  // side by side, at least one
  std::optional<CutPlane> cut;
  std::optional<CloseUp> close_up;  // empty: shows everything
  Vec3d view{0, 0, -1};             // into the scene
  Vec3d up{0, 1, 0};
  int width = 1600;  // of the whole picture
  int height = 1200;
  bool transparent = false;  // the background; else white
  bool ground = true;        // the shadow on the ground
  bool flat = false;         // one normal per face
  bool wireframe = false;
  bool same_scale = false;  // each shape is centred in its panel, all at one scale
  ImageFormat format = ImageFormat::png;
};

// Throws std::runtime_error in a build without a renderer.
void require_renderer();

// Returns the bytes of an image file. Throws as require_renderer, and if the machine has no OpenGL 3.3.
std::string draw_picture(const PictureRequest& request);

}  // namespace knead::command
