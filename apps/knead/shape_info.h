// What `knead info` says of a shape, and `knead check` first.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "knead/io/json.h"
#include "knead/io/shape_file.h"
#include "knead/mesh/measures.h"

namespace knead::command {

struct ShapeInfo {
  ShapeFile file;
  Measures measures;
  std::vector<std::string> notes;  // of the reader, and what is odd about the mesh
};

// Throws what read_shape throws.
ShapeInfo read_info(const std::string& shape);

// Its keys, in the order of the documentation.
Json to_json(const ShapeInfo& info);

// The same for people: a row for each key but the notes, and rows of the notes.
std::string table_of(const ShapeInfo& info);
std::string table_of_notes(const ShapeInfo& info);
std::string row(std::string_view name, std::string_view value);

}  // namespace knead::command
