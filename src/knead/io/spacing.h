// How fine the numbers of a file are against the shape.
#pragma once

#include <string>

#include "knead/mesh/mesh.h"

namespace knead::io_detail {

// Returns a note if floats where the mesh stands lie further apart than a hundredth of its mean edge (of points: of
// their mean distance on a surface as large as their box); else an empty text.
std::string spacing_note(const Mesh& mesh);

}  // namespace knead::io_detail
