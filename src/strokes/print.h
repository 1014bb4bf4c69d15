// The tool "print" on a surface (docs/decisions/0045-prints.md). Internal to the library.
#pragma once

#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "math/grey_tile.h"

namespace knead::tool_detail {

// Returns the face of a mesh that prints: what lies lowest, as seen from above; what is higher by less than the depth
// is grey. Throws InvalidInput for a mesh without faces.
GreyPattern face_of(const Mesh& mesh, const PrintStroke& stroke);

// Presses the pattern into the surface: passes GridStrokes to surface.apply until it returns false. They depend on the
// surface before the stroke only, so that it may be coarse where the mesh follows. `mirror`: of the stroke. Adds
// sentences to `remarks`. Throws InvalidInput, beginning with the key in quotes. Nothing has moved then. Time: about
// 10 ms for a letter, besides apply.
void print_on(const PrintStroke& stroke, const GreyPattern& pattern, const Mirror& mirror, const LiveSurface& surface,
              int threads, std::vector<std::string>& remarks);

}  // namespace knead::tool_detail
