// The attributes and vertices of a mesh as a GLB file can hold them.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "knead/mesh.h"

namespace knead::io_detail::glb {

// An attribute and its key in the file.
struct WritableAttribute {
  std::string key;
  Attribute attribute;  // of vertices or corners
};

struct WritableAttributes {
  std::vector<WritableAttribute> attributes;
  std::vector<std::string> losses;
};

// Returns the attributes that GLB can hold, and a sentence for each that it cannot.
WritableAttributes writable_attributes(const Mesh& mesh);

// The vertices of the file: those of the mesh in their order, then the copies that seams need.
struct SplitVertices {
  std::vector<std::uint32_t> original;      // the vertex of the mesh
  std::vector<std::size_t> corner;          // some corner of the mesh that uses it; kNone for a vertex in no face
  std::vector<std::uint32_t> corner_index;  // the vertex of the file for each corner of the mesh

  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
};

// Returns the vertices of the file; corners that differ in an attribute get separate vertices.
SplitVertices split_vertices(const Mesh& mesh, const std::vector<WritableAttribute>& held);

}  // namespace knead::io_detail::glb
