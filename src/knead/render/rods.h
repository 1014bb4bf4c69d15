// Solid rods and arrows as triangles.
#pragma once

#include "knead/render/surface.h"

namespace knead::render {

// Appends the arrow or line to the surface. Parts of no length or radius, or not finite, are left out. sides: of
// the prisms that stand for round things, at least 3.
void add_arrow(const Arrow& arrow, const Placement& placement, DrawSurface& surface, int sides = 48);
void add_line(const Line& line, const Placement& placement, DrawSurface& surface, int sides = 48);

}  // namespace knead::render
