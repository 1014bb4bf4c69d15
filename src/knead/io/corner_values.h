// Attributes of corners and of vertices, one as the other.
#pragma once

#include <optional>

#include "knead/mesh/mesh.h"

namespace knead::io_detail {

// An attribute of corners as one of vertices, if all corners at each vertex have the same values; vertices in no face
// have 0.
std::optional<Attribute> merge_corners(const Mesh& mesh, const Attribute& attribute);

// The first attribute of that name and number of components that vertices have, or that corners have and vertices can.
std::optional<Attribute> vertex_attribute(const Mesh& mesh, const std::string& name, int components);

}  // namespace knead::io_detail
