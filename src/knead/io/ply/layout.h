// What the header of a PLY file declares, and where the vertices are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "knead/io/stored_type.h"
#include "knead/mesh/mesh.h"

namespace knead::io_detail::ply {

struct Property {
  std::string name;
  StoredType type = StoredType::float32;  // of the number, or of the list's items
  bool is_list = false;
  StoredType count_type = StoredType::uint8;  // of a list's length
  std::size_t type_begin = 0;                 // the bytes of the word for `type` in the header
  std::size_t type_end = 0;
  std::size_t line_begin = 0;  // the bytes of the line, with its end
  std::size_t line_end = 0;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
  std::size_t count_begin = 0;  // the bytes of the word for `count` in the header
  std::size_t count_end = 0;
  std::size_t line_begin = 0;  // the bytes of the line, with its end
  std::size_t line_end = 0;
  std::size_t rows_begin = 0;  // the bytes of its rows; in text from the end of the line before to that of the last
  std::size_t rows_end = 0;
};

enum class Encoding { ascii, little_endian, big_endian };

struct Layout {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t body_begin = 0;      // the byte after the header
  std::size_t vertex_element = 0;  // index of the element "vertex"
  std::size_t vertex_begin = 0;    // the first byte of its first row; in text, a blank or line end before it at most
  std::vector<std::uint32_t> unplaced;  // rows of vertices that the mesh lacks (unplaced.h)
  bool surplus = false;                 // lines have more numbers than the header declares
  std::vector<std::string> notes;       // on the header
};

}  // namespace knead::io_detail::ply
