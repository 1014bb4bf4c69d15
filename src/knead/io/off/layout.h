// Where the vertices of an OFF file are, and what a mesh does not hold.
#pragma once

#include <bit>
#include <cstddef>

namespace knead::io_detail::off {

struct Layout {
  bool binary = false;
  std::endian order = std::endian::big;  // of a binary file
  bool color_counts = false;             // whether the faces of a binary file say how many color numbers follow
  std::size_t vertex_begin = 0;          // the first byte after the counts
  std::size_t width = 0;                 // numbers per vertex
  std::size_t faces_end = 0;             // the byte after the last face
  bool all_read = true;                  // every color and further number is an attribute of the mesh
};

}  // namespace knead::io_detail::off
