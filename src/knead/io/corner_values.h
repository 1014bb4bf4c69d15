// Attributes of corners and of vertices, one as the other.
#pragma once

#include <optional>

#include "knead/mesh/mesh.h"

namespace knead {

// An attribute of corners as one of vertices, if all corners at each vertex have the same values; vertices in no face
// have 0.
std::optional<Attribute> merge_corners(const Mesh& mesh, const Attribute& attribute);

}  // namespace knead
