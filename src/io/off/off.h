// OFF (Geomview, Object File Format), text and binary: its header, and where a file has its vertices.
#pragma once

#include <bit>
#include <cstddef>
#include <string>

#include "io/codec.h"
#include "knead/io.h"

namespace knead::detail::off {

// [ST][C][N][n]OFF, the letters in any order, or no keyword: the counts, then a vertex on each line, then a face on
// each. After x y z stand the normal, then the color, as Geomview says, or the color first, as MeshLab writes: what the
// numbers of most vertices can be. Attributes: "normal" (N), "uv" (ST), "color" of vertices (C, or three or four more
// numbers than the keyword says) and of faces, "color_index" of faces with one number each; colors are uint8 where all
// are whole numbers and one is above 1.
// OFF BINARY is read in either byte order, and with the count of color numbers after each face or without (as PMP
// writes), whichever takes up the whole file.
void read(ShapeFile& shape, const std::string& name);

// The positions of the vertices in an OFF file, and its contents that a mesh does not hold.

struct Layout {
  bool binary = false;
  std::endian order = std::endian::big;  // of a binary file
  bool color_counts = false;             // whether the faces of a binary file say how many color numbers follow
  std::size_t vertex_begin = 0;          // the first byte after the counts
  std::size_t width = 0;                 // numbers per vertex
  std::size_t uv = 0;                    // of them, the last ones
  bool colors_first = false;             // the normal stands after the color
  std::size_t faces_end = 0;             // the byte after the last face
  bool all_read = true;                  // every color and further number is an attribute of the mesh
};

// The numbers of each vertex, by the keyword; texture coordinates are the last ones.
struct Fields {
  bool normals = false;
  bool colors = false;  // three or four numbers; four in a binary file
  bool uv = false;

  std::size_t without_colors() const { return 3 + (normals ? 3 : 0) + (uv ? 2 : 0); }
};

// The beginning of a file.
struct Header {
  Fields fields;
  bool binary = false;
  bool lower_case = false;       // the keyword
  std::size_t counts_begin = 0;  // the byte where the counts may begin
};

// Throws InvalidInput for text that is no OFF, and for other than three dimensions.
Header parse_header(std::string_view bytes, const std::string& name);

}  // namespace knead::detail::off
