// The face of a mesh as the pattern of the tool "print" (docs/decisions/0045-prints.md). Internal to the library.
#pragma once

#include "knead/mesh.h"
#include "knead/stroke.h"
#include "math/grey_tile.h"

namespace knead::tool_detail {

// Returns the face of a mesh that prints: what lies lowest, as seen from above; what is higher by less than the depth
// is grey. Throws InvalidInput for a mesh without faces.
GreyPattern face_of(const Mesh& mesh, const PrintStroke& stroke);

}  // namespace knead::tool_detail
