// The vertices of a new mesh as numbers of a GLB file's primitives. Internal to the GLB writer.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "knead/io/glb/attributes.h"
#include "knead/io/glb/edit.h"
#include "knead/io/new_mesh.h"

namespace knead::io_detail::glb {

class NewVertices {
 public:
  // The shape and the document must outlive it.
  NewVertices(const NewMesh& shape, const Document& document);

  // Whether a face has the same corners as a face of the source: positions and attributes.
  bool is_same_face(std::size_t source_face, std::size_t face) const;

  // For a block of points and lines, whose vertices are in no face: its vertices in the new mesh. Empty where none of
  // them changed, or where the mesh has not as many vertices in no face as the source.
  std::vector<std::uint32_t> moved_points(const Block& block) const;

  // Appends an accessor for each attribute that the block has, of these vertices in this order; by key. Numbers of
  // vertices that are where a corner of their faces' sources was are the source's bits where they did not change.
  // Throws InvalidInput where a float cannot hold a coordinate.
  std::map<std::string, std::size_t> append(const Block& block, const std::vector<std::uint32_t>& vertices,
                                            Edit& edit) const;

 private:
  bool is_same_vertex(std::uint32_t before, std::uint32_t after) const;
  void find_origins();
  void find_points();
  std::size_t append_positions(const Block& block, const std::vector<std::uint32_t>& vertices, Edit& edit) const;
  std::size_t append_attribute(const Block& block, const Semantic& semantic, const std::vector<std::uint32_t>& vertices,
                               Edit& edit) const;

  const NewMesh& shape_;
  const Document& document_;
  std::vector<std::uint32_t> origin_;  // of each new vertex: the source's that was where it is, or kNone
  std::vector<std::uint32_t> point_;   // of each vertex of the source in no face: the new mesh's, or kNone
};

}  // namespace knead::io_detail::glb
