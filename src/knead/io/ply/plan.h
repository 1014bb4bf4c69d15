// Where the numbers of a PLY file go in a mesh.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "knead/io/ply/layout.h"
#include "knead/mesh/mesh.h"

namespace knead::io_detail::ply {

// What becomes of the numbers of one property: read over, a coordinate (component: the axis), a component of an
// attribute, the vertices of faces or of strips of triangles, or u v of each corner of a face.
struct Sink {
  enum class Kind { skip, coordinate, attribute, faces, strips, corner_uv };

  Kind kind = Kind::skip;
  std::size_t attribute = 0;  // number in the mesh
  std::size_t component = 0;
};

struct Plan {
  std::vector<std::vector<Sink>> sinks;  // of each element's properties
  std::vector<Attribute> attributes;     // without values
};

// Throws InvalidInput where the vertices or the faces lack what makes a shape.
Plan make_plan(const Layout& layout, const std::string& name);

// Adds what is lost of the rows of vertices and faces when they are written anew.
void append_row_losses(const Layout& layout, std::vector<std::string>& losses);

// Whether a list holds the vertices of faces, or of strips of triangles.
bool is_index_list(const Element& element, const Property& property);

}  // namespace knead::io_detail::ply
