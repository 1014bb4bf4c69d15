// What a GLB file can hold of a mesh. Internal to the GLB writer.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "knead/mesh/mesh.h"

namespace knead::io_detail::glb {

// An attribute and what it is called in the file.
struct Held {
  std::string key;
  Attribute attribute;  // of vertices or corners
};

struct Holdings {
  std::vector<Held> attributes;
  std::vector<std::string> losses;
};

Holdings sort_attributes(const Mesh& mesh);

// The vertices of the file: the mesh's in their order, then the further ones that seams need.
struct SplitVertices {
  std::vector<std::uint32_t> original;      // the vertex of the mesh
  std::vector<std::size_t> corner;          // some corner of the mesh that uses it; kNone for a vertex in no face
  std::vector<std::uint32_t> corner_index;  // the vertex of the file for each corner of the mesh

  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
};

// Corners that differ in an attribute get vertices of their own.
SplitVertices split_vertices(const Mesh& mesh, const std::vector<Held>& held);

}  // namespace knead::io_detail::glb
