// A tool as the paper draws it: the surface r = inner red, r = outer green, arrows for its motion.
#pragma once

#include "knead/flow/segment.h"
#include "knead/math/box.h"
#include "knead/render/scene.h"

namespace knead::command {

// Adds the tool of one stroke to the scene, drawn from the stroke's flow: at its start, with arrows that show the inner
// motion; where it travels also, fainter, at its end, and the path in between. `around` is the box of the shape.
void draw_tool(const Flow& stroke, const Box& around, render::Scene& scene);

// The same tool where it is at a moment of its stroke, given in segments from the beginning, and the path of the
// stroke.
void draw_tool_at(const Flow& stroke, double moment, const Box& around, render::Scene& scene);

}  // namespace knead::command
