// Where the numbers of a PLY file go in a mesh.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "knead/io/ply_layout.h"
#include "knead/mesh/mesh.h"

namespace knead {

// What becomes of the numbers of one property: read over, a coordinate (component: the axis), a component of an
// attribute, the vertices of faces or of strips of triangles, or u v of each corner of a face.
struct PlySink {
  enum class Kind { skip, coordinate, attribute, faces, strips, corner_uv };

  Kind kind = Kind::skip;
  std::size_t attribute = 0;  // number in the mesh
  std::size_t component = 0;
};

struct PlyPlan {
  std::vector<std::vector<PlySink>> sinks;  // of each element's properties
  std::vector<Attribute> attributes;        // without values
};

// Throws InvalidInput where the vertices or the faces lack what makes a shape.
PlyPlan plan_ply(const PlyLayout& layout, const std::string& name);

// Whether a list holds the vertices of faces, or of strips of triangles.
bool is_index_list(const PlyElement& element, const PlyProperty& property);

}  // namespace knead
