// Writing a mesh as a new PCD file.
#include <algorithm>
#include <bit>

#include "knead/io/binary_floats.h"
#include "knead/io/cloud/pcd.h"
#include "knead/io/colors.h"

namespace knead::io_detail::pcd {
namespace {

constexpr bool kSwapped = std::endian::native == std::endian::big;

bool is_color(const Attribute& a) { return a.name == "color" && (a.components == 3 || a.components == 4); }
bool is_normal(const Attribute& a) { return a.name == "normal" && a.components == 3; }

bool is_held(const Attribute& attribute) {
  if (attribute.domain != Domain::vertex) return false;
  if (is_color(attribute) || is_normal(attribute)) return true;
  constexpr std::string_view taken[] = {"x",        "y",        "z",      "rgb",   "rgba", "normal_x",
                                        "normal_y", "normal_z", "normal", "color", "uv"};
  const bool has_blank = attribute.name.find_first_of(" \t\r\n\v\f#") != std::string::npos;
  return attribute.components == 1 && !attribute.name.empty() && !has_blank &&
         std::find(std::begin(taken), std::end(taken), attribute.name) == std::end(taken);
}

// The lines that have a word for each field.
struct Lines {
  std::string names = "FIELDS";
  std::string sizes = "SIZE";
  std::string types = "TYPE";
  std::string counts = "COUNT";

  void add(const std::string& name, std::size_t size, const char* type) {
    names += ' ' + name;
    sizes += ' ' + std::to_string(size);
    types += std::string(" ") + type;
    counts += " 1";
  }
};

StoredType stored_type(NumberType type) {
  for (const StoredType stored : {StoredType::int8, StoredType::uint8, StoredType::int16, StoredType::uint16,
                                  StoredType::int32, StoredType::uint32, StoredType::float32}) {
    if (number_type(stored) == type) return stored;
  }
  return StoredType::float64;
}

const char* letter_of(NumberType type) {
  if (!is_integer(type)) return "F";
  const bool is_unsigned = type == NumberType::uint8 || type == NumberType::uint16 || type == NumberType::uint32;
  return is_unsigned ? "U" : "I";
}

void append_fields(Lines& lines, const Attribute& attribute) {
  if (is_normal(attribute)) {
    for (const char* axis : {"x", "y", "z"}) lines.add(std::string("normal_") + axis, 4, "F");
  } else if (is_color(attribute)) {
    lines.add(attribute.components == 4 ? "rgba" : "rgb", 4, "U");
  } else {
    lines.add(attribute.name, io_detail::size_of(attribute.type), letter_of(attribute.type));
  }
}

void append_values(std::string& bytes, const Attribute& attribute, std::size_t i) {
  const std::size_t n = static_cast<std::size_t>(attribute.components);
  const double* values = attribute.values.data() + i * n;
  if (is_normal(attribute)) {
    for (std::size_t c = 0; c < 3; ++c) {
      append_binary(bytes, StoredType::float32, nearest_of(StoredType::float32, values[c]), kSwapped);
    }
  } else if (is_color(attribute)) {
    std::uint32_t bits = 0;
    constexpr int shifts[4] = {16, 8, 0, 24};
    for (std::size_t c = 0; c < n; ++c) {
      bits |= static_cast<std::uint32_t>(as_byte(values[c], attribute.type)) << shifts[c];
    }
    append_binary(bytes, StoredType::uint32, bits, kSwapped);
  } else {
    const StoredType type = stored_type(attribute.type);
    append_binary(bytes, type, nearest_of(type, values[0]), kSwapped);
  }
}

}  // namespace

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  if (!options.double_coordinates) check_fits_floats(mesh.positions);
  const StoredType coordinate = options.double_coordinates ? StoredType::float64 : StoredType::float32;
  Lines lines;
  for (const char* axis : {"x", "y", "z"}) lines.add(axis, size_of(coordinate), "F");
  for (const Attribute& attribute : mesh.attributes) {
    if (is_held(attribute)) append_fields(lines, attribute);
  }
  const std::string count = std::to_string(mesh.vertex_count());
  std::string bytes = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + lines.names + "\n" + lines.sizes +
                      "\n" + lines.types + "\n" + lines.counts + "\nWIDTH " + count +
                      "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_binary(bytes, coordinate, mesh.positions[i][axis], kSwapped);
    for (const Attribute& attribute : mesh.attributes) {
      if (is_held(attribute)) append_values(bytes, attribute, i);
    }
  }
  return bytes;
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  if (mesh.face_count() > 0) losses.emplace_back("PCD cannot hold faces");
  for (const Attribute& attribute : mesh.attributes) {
    if (!is_held(attribute)) {
      losses.push_back("PCD cannot hold '" + attribute.name + "'");
    } else if (is_color(attribute) && attribute.type != NumberType::uint8) {
      losses.emplace_back("PCD holds colors as whole numbers from 0 to 255");
    }
  }
  return losses;
}

}  // namespace knead::io_detail::pcd
