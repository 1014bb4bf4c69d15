// PCD, the point files of the Point Cloud Library (PCD_V7), as text and binary: its row of the format table
// (formats.h).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/io/shape_file.h"
#include "knead/io/stored_type.h"

namespace knead::io_detail::pcd {

// What a column of numbers means.
enum class Role { other, position, normal, color };

struct Field {
  std::string name;
  StoredType type = StoredType::float32;
  std::size_t count = 1;   // numbers
  std::size_t offset = 0;  // of its first byte in a row, or of its first word
  Role role = Role::other;
  std::size_t axis = 0;  // of a position or a normal
};

struct Layout {
  std::vector<Field> fields;
  bool ascii = true;
  std::size_t compressed = 0;  // where the word 'binary_compressed' begins; 0: none
  std::size_t points = 0;
  std::size_t row_size = 0;             // bytes, or words
  std::size_t body_begin = 0;           // the byte after the header
  std::vector<std::uint32_t> unplaced;  // rows of points that the mesh lacks (unplaced.h)
};

// Reads the header. Throws InvalidInput that names the line.
Layout parse_header(std::string_view bytes, const std::string& name);

// Turns a file with 'DATA binary_compressed' into one with 'DATA binary'; leaves others as they are and returns false.
// Throws InvalidInput for a damaged one.
bool uncompress(std::string& bytes, const std::string& name);

// Points whose coordinates are not finite, which organised scans have, are left out of the mesh. "normal" (fields
// normal_x, normal_y, normal_z), "color" (3, of rgb; 4, of rgba; of type F as bits or as whole numbers), other fields
// of one number under their names. The pose of the viewpoint is not applied. A compressed file is kept, and written,
// uncompressed; a note says so.
ShapeFile parse(std::string bytes, const std::string& name);
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// A new binary file: coordinates as floats, or doubles if the options say so, and the attributes of vertices.
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
bool stores_floats(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);

}  // namespace knead::io_detail::pcd
