// A tool as the paper draws it: the surface r = inner red, r = outer green, arrows for its motion.
#pragma once

#include "knead/math/box.h"
#include "knead/render/drawn_tool.h"
#include "knead/render/scene.h"
#include "knead/render/surface_cache.h"
#include "knead/render/tool_surface.h"

namespace knead::render {

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
