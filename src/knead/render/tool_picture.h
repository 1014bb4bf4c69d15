// A tool as the paper draws it: the surface r = inner red, r = outer green, arrows for its motion.
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

struct ToolDrawing {
  SurfaceDetail detail{};
  SurfaceCache* cache = nullptr;  // remembers surfaces from one picture to the next
};

// Adds the tool of one stroke to the scene, drawn from the stroke's flow, with arrows that show the inner motion. On
// its whole way: at its start; where it travels also, fainter, at its end, and the path in between. At a moment: where
// it then is, and the path. The tool of a stamp is its shape; at a moment with the regions of its contacts. `around` is
// the box of the deformed shape.
void draw_tool(const DrawnTool& tool, const Box& around, Scene& scene, const ToolDrawing& how = {});

}  // namespace knead::render
