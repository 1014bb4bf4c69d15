// Writing a mesh as a new PLY file.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "knead/io/corner_values.h"
#include "knead/io/layout.h"
#include "knead/io/ply/header.h"
#include "knead/io/ply/layout.h"
#include "knead/io/ply/plan.h"
#include "knead/io/ply/ply.h"
#include "knead/io/text.h"
#include "knead/io/unplaced.h"
#include "knead/math/error.h"

namespace knead::io_detail::ply {
namespace {

// The attributes as PLY holds them: numbers per vertex, numbers per face, and u v per corner as a list per face.
struct Holdings {
  std::vector<Attribute> vertex;
  std::vector<Attribute> face;
  std::optional<Attribute> corner_uv;
  std::vector<std::string> losses;
};

Holdings sort_attributes(const Mesh& mesh) {
  Holdings held;
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain == Domain::vertex) {
      held.vertex.push_back(attribute);
    } else if (attribute.domain == Domain::face) {
      held.face.push_back(attribute);
    } else if (std::optional<Attribute> merged = merge_corners(mesh, attribute)) {
      held.vertex.push_back(*std::move(merged));
    } else if (attribute.name == "uv" && attribute.components == 2) {
      held.corner_uv = attribute;
    } else {
      held.losses.push_back("PLY cannot hold '" + attribute.name + "' that differs between the faces at a vertex");
    }
  }
  return held;
}

std::string property_name(const Attribute& attribute, int component) {
  const std::size_t i = static_cast<std::size_t>(component);
  if (attribute.name == "normal" && i < 3) return std::array{"nx", "ny", "nz"}[i];
  if (attribute.name == "uv" && i < 2) return std::array{"s", "t"}[i];
  if (attribute.name == "color" && i < 4) return std::array{"red", "green", "blue", "alpha"}[i];
  return attribute.components == 1 ? attribute.name : attribute.name + std::to_string(component);
}

void append_properties(std::string& header, const std::vector<Attribute>& attributes) {
  for (const Attribute& attribute : attributes) {
    for (int c = 0; c < attribute.components; ++c) {
      header +=
          "property " + std::string(type_name(stored_type(attribute.type))) + " " + property_name(attribute, c) + "\n";
    }
  }
}

// A value of an attribute as near as its type can hold it.
double nearest(NumberType type, double value) {
  constexpr double most = std::numeric_limits<float>::max();
  return type == NumberType::float32 ? std::clamp(value, -most, most) : value;
}

void append_values(std::string& bytes, const std::vector<Attribute>& attributes, std::size_t element) {
  for (const Attribute& attribute : attributes) {
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    for (std::size_t c = 0; c < n; ++c)
      append_binary(bytes, stored_type(attribute.type), nearest(attribute.type, attribute.values[element * n + c]),
                    is_swapped(Encoding::little_endian));
  }
}

std::size_t largest_face(const Mesh& mesh) {
  std::size_t largest = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) largest = std::max(largest, mesh.face(f).size());
  return largest;
}

std::string header_for(const Mesh& mesh, const Holdings& held, StoredType coordinate, StoredType length,
                       StoredType uv_length) {
  const std::string type(type_name(coordinate));
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertex_count()) +
                       "\nproperty " + type + " x\nproperty " + type + " y\nproperty " + type + " z\n";
  append_properties(header, held.vertex);
  header += "element face " + std::to_string(mesh.face_count()) + "\nproperty list " + std::string(type_name(length)) +
            " int vertex_indices\n";
  if (held.corner_uv) header += "property list " + std::string(type_name(uv_length)) + " float texcoord\n";
  append_properties(header, held.face);
  return header + "end_header\n";
}

void check_range(const Mesh& mesh) {
  for (const Vec3d& p : mesh.positions) {
    if (fits_float(p.x) && fits_float(p.y) && fits_float(p.z)) continue;
    throw InvalidInput("a coordinate does not fit in a float; use double precision");
  }
}

void append_corner_uv(std::string& bytes, const Mesh& mesh, const Attribute& uv, std::size_t f, StoredType length) {
  append_binary(bytes, length, 2.0 * static_cast<double>(mesh.face(f).size()), is_swapped(Encoding::little_endian));
  for (std::size_t i = 2 * std::size_t{mesh.face_begin[f]}; i < 2 * std::size_t{mesh.face_begin[f + 1]}; ++i) {
    append_binary(bytes, StoredType::float32, nearest(NumberType::float32, uv.values[i]),
                  is_swapped(Encoding::little_endian));
  }
}

}  // namespace

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  if (!options.double_coordinates) check_range(mesh);
  const bool swapped = is_swapped(Encoding::little_endian);
  const Holdings held = sort_attributes(mesh);
  const StoredType coordinate = options.double_coordinates ? StoredType::float64 : StoredType::float32;
  const std::size_t largest = largest_face(mesh);
  const StoredType length = largest < 256 ? StoredType::uint8 : StoredType::uint32;
  const StoredType uv_length = largest < 128 ? StoredType::uint8 : StoredType::uint32;
  std::string bytes = header_for(mesh, held, coordinate, length, uv_length);
  bytes.reserve(bytes.size() + mesh.vertex_count() * 24 + mesh.face_count() * 4 + mesh.corner_vertex.size() * 4);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_binary(bytes, coordinate, mesh.positions[i][axis], swapped);
    append_values(bytes, held.vertex, i);
  }
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    append_binary(bytes, length, static_cast<double>(mesh.face(f).size()), swapped);
    for (const std::uint32_t v : mesh.face(f)) append_binary(bytes, StoredType::int32, v, swapped);
    if (held.corner_uv) append_corner_uv(bytes, mesh, *held.corner_uv, f, uv_length);
    append_values(bytes, held.face, f);
  }
  return bytes;
}

void append_row_losses(const Layout& layout, std::vector<std::string>& losses) {
  if (!layout.unplaced.empty()) losses.push_back(unplaced_loss(layout.unplaced.size()));
  if (layout.surplus) losses.emplace_back("numbers beyond those that the header declares are left out");
}

std::vector<std::string> losses(const Mesh& mesh) { return sort_attributes(mesh).losses; }

std::vector<std::string> source_losses(const ShapeFile& source) {
  std::vector<std::string> losses;
  for (const Element& element : layout_of<Layout>(source).elements) {
    const bool is_known = element.name == "vertex" || element.name == "face" || element.name == "tristrips";
    if (!is_known) losses.push_back("element '" + element.name + "' is left out");
    for (const Property& property : element.properties) {
      const bool is_read = is_index_list(element, property) || (element.name == "face" && property.name == "texcoord");
      if (is_known && property.is_list && !is_read) losses.push_back("list '" + property.name + "' is left out");
    }
  }
  append_row_losses(layout_of<Layout>(source), losses);
  return losses;
}

}  // namespace knead::io_detail::ply
