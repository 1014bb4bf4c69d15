// What `knead render` draws, as plain values that need no renderer.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/math/vec3.h"
#include "knead/mesh/mesh.h"

namespace knead::command {

struct PictureRequest {
  std::vector<Mesh> shapes;  // side by side, at least one
  std::vector<Flow> tools;   // drawn over the first shape
  Vec3d view{0, 0, -1};      // into the scene
  Vec3d up{0, 1, 0};
  int width = 1600;  // of the whole picture
  int height = 1200;
  bool transparent = false;  // the background; else white
  bool ground = true;        // the shadow on the ground
  bool flat = false;         // one normal per face
  bool wireframe = false;
  bool same_scale = false;  // each shape in the middle of its own part, all at one scale
};

// Throws std::runtime_error in a build without a renderer.
void require_renderer();

// The bytes of a PNG file. Throws as require_renderer, and where the machine has no OpenGL 3.3.
std::string draw_picture(const PictureRequest& request);

}  // namespace knead::command
