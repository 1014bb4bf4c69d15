// Strokes seen in a mirror.
#pragma once

#include "knead/tool/stroke.h"

namespace knead {

// The stroke that does to the mirror image of a shape, in the plane where the coordinate `axis` (0: x, 1: y, 2: z) is
// zero, what `stroke` does to the shape; exact but for the rounding of the evaluation. A stamp's pose is mirrored so
// that it fits the mirror image of the tool, which its `mesh` must then name. Throws InvalidInput for marked regions
// given by vertices: their mirror images need not be vertices.
Stroke mirrored(const Stroke& stroke, int axis);

}  // namespace knead
