// What `knead info` and `knead check` print about a shape.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "knead/io/json.h"
#include "knead/io/shape_file.h"
#include "knead/mesh/measures.h"
#include "streams.h"

namespace knead::command {

struct ShapeInfo {
  ShapeFile file;
  Measures measures;
  std::vector<std::string> notes;  // from the reader, and on defects of the mesh
};

// Throws what read_shape_or_stream throws.
ShapeInfo read_info(const std::string& shape, const StreamFormat& format);

// Returns the keys in the order of the documentation.
Json to_json(const ShapeInfo& info);

// Return the same as text: a row for each key except the notes; and the rows of the notes.
std::string table_of(const ShapeInfo& info);
std::string table_of_notes(const ShapeInfo& info);
std::string row(std::string_view name, std::string_view value);

}  // namespace knead::command
