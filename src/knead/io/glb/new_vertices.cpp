#include "knead/io/glb/new_vertices.h"
#include "knead/io/number_types.h"

#include <fmt/format.h>

#include <algorithm>

#include "knead/io/text.h"
#include "knead/math/error.h"

namespace knead::io_detail::glb {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

std::vector<std::uint32_t> vertices_in_no_face(const Mesh& mesh) {
  std::vector<bool> used(mesh.vertex_count(), false);
  for (const std::uint32_t v : mesh.corner_vertex) used[v] = true;
  std::vector<std::uint32_t> unused;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!used[v]) unused.push_back(v);
  }
  return unused;
}

// The values of an attribute at a vertex as the file holds them: in the node's coordinates, v downwards.
std::vector<double> to_local(const Semantic& semantic, const Placement& placement, std::vector<double> values) {
  const std::string_view key = semantic.key;
  const auto set_direction = [&](const Mat3d& map) {
    const Vec3d unit = direction(map * Vec3d{values[0], values[1], values[2]});
    for (std::size_t axis = 0; axis < 3; ++axis) values[axis] = unit[axis];
  };
  if (key == "NORMAL") {
    const Mat3d& linear = placement.linear;
    set_direction(Mat3d(linear.column(0), linear.column(1), linear.column(2)));
  } else if (key == "TANGENT") {
    set_direction(placement.inverse);
    values[3] = (values[3] < 0 ? -1 : 1) * (determinant(placement.linear) < 0 ? -1 : 1);
  } else if (key == "TEXCOORD_0") {
    values[1] = 1 - values[1];
  }
  return values;
}

// Numbers of one type, appended as bytes.
struct Elements {
  NumberType type;
  std::size_t components;
  std::string bytes = {};

  void append(double value) {
    const double number = nearest_of(type, value);
    if (type == NumberType::float32) return append_float(bytes, static_cast<float>(number));
    const unsigned whole = static_cast<unsigned>(number);
    bytes += static_cast<char>(whole & 0xffu);
    if (type == NumberType::uint16) bytes += static_cast<char>(whole >> 8);
  }

  // Each element of vertices begins at a multiple of four bytes.
  void end_element() { bytes.resize((bytes.size() + 3) / 4 * 4, '\0'); }

  std::string members(std::size_t count) const {
    const int component_type = type == NumberType::uint8 ? 5121 : (type == NumberType::uint16 ? 5123 : 5126);
    return fmt::format(R"("componentType":{},"count":{},"type":"VEC{}"{})", component_type, count, components,
                       type == NumberType::float32 ? "" : R"(,"normalized":true)");
  }
};

}  // namespace

NewVertices::NewVertices(const NewMesh& shape, const Document& document) : shape_(shape), document_(document) {
  find_origins();
  find_points();
}

void NewVertices::find_origins() {
  const Mesh& before = shape_.source.mesh;
  origin_.assign(shape_.mesh.vertex_count(), kNone);
  for (std::size_t f = 0; f < shape_.mesh.face_count(); ++f) {
    for (const std::uint32_t v : shape_.mesh.face(f)) {
      for (const std::uint32_t old : before.face(shape_.face_source[f])) {
        if (before.positions[old] == shape_.mesh.positions[v]) origin_[v] = old;
      }
    }
  }
}

void NewVertices::find_points() {
  point_.assign(shape_.source.mesh.vertex_count(), kNone);
  const std::vector<std::uint32_t> before = vertices_in_no_face(shape_.source.mesh);
  const std::vector<std::uint32_t> after = vertices_in_no_face(shape_.mesh);
  if (before.size() != after.size()) return;
  for (std::size_t i = 0; i < before.size(); ++i) {
    point_[before[i]] = after[i];
    if (shape_.source.mesh.positions[before[i]] == shape_.mesh.positions[after[i]]) origin_[after[i]] = before[i];
  }
}

bool NewVertices::is_same_vertex(std::uint32_t before, std::uint32_t after) const {
  if (!(shape_.source.mesh.positions[before] == shape_.mesh.positions[after])) return false;
  for (std::size_t a = 0; a < shape_.mesh.attributes.size(); ++a) {
    const std::size_t n = static_cast<std::size_t>(shape_.mesh.attributes[a].components);
    const double* old_values = shape_.source.mesh.attributes[a].values.data() + before * n;
    const double* new_values = shape_.mesh.attributes[a].values.data() + after * n;
    if (!std::equal(old_values, old_values + n, new_values)) return false;
  }
  return true;
}

bool NewVertices::is_same_face(std::size_t source_face, std::size_t face) const {
  const std::span<const std::uint32_t> before = shape_.source.mesh.face(source_face);
  const std::span<const std::uint32_t> after = shape_.mesh.face(face);
  return std::equal(before.begin(), before.end(), after.begin(), after.end(),
                    [&](std::uint32_t a, std::uint32_t b) { return is_same_vertex(a, b); });
}

std::vector<std::uint32_t> NewVertices::moved_points(const Block& block) const {
  std::vector<std::uint32_t> vertices;
  bool moved = false;
  for (std::size_t i = block.first; i < block.first + block.count; ++i) {
    if (point_[i] == kNone) return {};
    vertices.push_back(point_[i]);
    moved = moved || !is_same_vertex(static_cast<std::uint32_t>(i), point_[i]);
  }
  return moved ? vertices : std::vector<std::uint32_t>{};
}

std::map<std::string, std::size_t> NewVertices::append(const Block& block, const std::vector<std::uint32_t>& vertices,
                                                       Edit& edit) const {
  std::map<std::string, std::size_t> accessors{{"POSITION", append_positions(block, vertices, edit)}};
  for (const Semantic& semantic : kSemantics) {
    if (block.*semantic.accessor) accessors[semantic.key] = append_attribute(block, semantic, vertices, edit);
  }
  return accessors;
}

std::size_t NewVertices::append_positions(const Block& block, const std::vector<std::uint32_t>& vertices,
                                          Edit& edit) const {
  const std::vector<double> old =
      read_accessor(document_, block.position, find_accessor(document_, block.position), true);
  std::vector<float> floats;
  floats.reserve(3 * vertices.size());
  for (const std::uint32_t v : vertices) {
    const std::size_t origin = std::size_t{origin_[v]} - block.first;
    const bool is_old = origin_[v] != kNone && origin < block.count;
    const Vec3d local = is_old ? Vec3d{old[3 * origin], old[3 * origin + 1], old[3 * origin + 2]}
                               : block.placement.inverse * (shape_.mesh.positions[v] - block.placement.offset);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!fits_float(local[axis])) {
        throw InvalidInput(
            fmt::format("the coordinates of vertex {} do not fit in floats, the only type that GLB has for them; "
                        "write another format",
                        v));
      }
      floats.push_back(static_cast<float>(local[axis]));
    }
  }
  return edit.append_accessor(floats, 3);
}

std::size_t NewVertices::append_attribute(const Block& block, const Semantic& semantic,
                                          const std::vector<std::uint32_t>& vertices, Edit& edit) const {
  const Attribute& before = *shape_.source.mesh.find_attribute(semantic.name);
  const Attribute& after = *shape_.mesh.find_attribute(semantic.name);
  const std::size_t index = *(block.*semantic.accessor);
  const Accessor accessor = find_accessor(document_, index);
  const std::vector<double> old = read_accessor(document_, index, accessor, after.type == NumberType::float32);
  const std::size_t n = static_cast<std::size_t>(after.components);
  Elements elements{after.type, accessor.components};
  for (const std::uint32_t v : vertices) {
    const std::size_t origin = std::size_t{origin_[v]} - block.first;
    const double* values = after.values.data() + v * n;
    const bool is_old = origin_[v] != kNone && origin < block.count &&
                        std::equal(values, values + n, before.values.data() + std::size_t{origin_[v]} * n);
    const std::vector<double> local =
        is_old ? std::vector<double>(old.data() + origin * accessor.components,
                                     old.data() + (origin + 1) * accessor.components)
               : to_local(semantic, block.placement, std::vector<double>(values, values + accessor.components));
    for (const double value : local) elements.append(value);
    elements.end_element();
  }
  const std::size_t stride = elements.bytes.size() / vertices.size();
  const bool is_padded = stride != accessor.components * (after.type == NumberType::uint8    ? 1u
                                                          : after.type == NumberType::uint16 ? 2u
                                                                                             : 4u);
  return edit.append_elements(elements.bytes, is_padded ? stride : 0, kVertexData, elements.members(vertices.size()));
}

}  // namespace knead::io_detail::glb
