// Draws a tool as in the paper: the surface r = inner red, r = outer green, arrows for its motion.
#pragma once

#include <optional>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/math/box.h"
#include "knead/math/vec3.h"
#include "knead/mesh/mesh.h"
#include "knead/render/scene.h"
#include "knead/render/surface_cache.h"
#include "knead/render/tool_surface.h"

namespace knead::render {

// The shape that a stamp presses in, in its pose before it moves, and the path of its origin.
struct StampTool {
  Mesh mesh;
  std::vector<Vec3d> path;
};

// The tool of a stroke along its whole path, or at one moment, which counts in segments of the stroke.
struct DrawnTool {
  Flow stroke;
  std::optional<StampTool> stamp;
  std::optional<double> moment;
};

// How finely a tool is drawn.
struct ToolDrawing {
  SurfaceDetail detail{};
  SurfaceCache* cache = nullptr;  // keeps surfaces from one picture to the next, if not null
};

// Adds the tool of one stroke to the scene, with arrows that show the inner motion.
//   without a moment  the tool at its start and, if it moves, its path and, fainter, the tool at its end
//   at a moment       the tool where it is then, and its path
// Of a grid the box of its nodes in use is drawn. The tool of a stamp is drawn as its shape, at a moment also with the
// regions of its contacts. `around` is the bounding box of the deformed shape.
void draw_tool(const DrawnTool& tool, const Box& around, Scene& scene, const ToolDrawing& how = {});

}  // namespace knead::render
