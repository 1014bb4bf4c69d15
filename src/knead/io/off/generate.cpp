// Writing a mesh as a new OFF file.
#include <algorithm>
#include <optional>

#include "knead/io/colors.h"
#include "knead/io/corner_values.h"
#include "knead/io/off/off.h"
#include "knead/io/text.h"

namespace knead::io_detail::off {
namespace {

bool is_color(const Attribute& attribute) {
  const bool has_scale = attribute.type == NumberType::uint8 || attribute.type == NumberType::uint16 ||
                         attribute.type == NumberType::float32 || attribute.type == NumberType::float64;
  return attribute.name == "color" && (attribute.components == 3 || attribute.components == 4) && has_scale;
}

bool is_color_index(const Attribute& attribute) {
  return attribute.name == "color_index" && attribute.components == 1 && attribute.type == NumberType::int32;
}

// What of a mesh's attributes OFF holds.
struct Holdings {
  std::optional<Attribute> normal;
  std::optional<Attribute> color;
  std::optional<Attribute> uv;
  const Attribute* face_color = nullptr;

  bool holds(const Attribute& attribute) const {
    if (attribute.domain == Domain::face) return &attribute == face_color;
    for (const std::optional<Attribute>* held : {&normal, &color, &uv}) {
      if (*held && (*held)->name == attribute.name && (*held)->components == attribute.components) return true;
    }
    return false;
  }
};

Holdings sort_attributes(const Mesh& mesh) {
  Holdings held;
  held.normal = vertex_attribute(mesh, "normal", 3);
  held.uv = vertex_attribute(mesh, "uv", 2);
  held.color = vertex_attribute(mesh, "color", 4);
  if (!held.color) held.color = vertex_attribute(mesh, "color", 3);
  if (held.color && !is_color(*held.color)) held.color.reset();
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain != Domain::face || held.face_color != nullptr) continue;
    if (is_color(attribute) || is_color_index(attribute)) held.face_color = &attribute;
  }
  return held;
}

void append_numbers(std::string& text, const std::optional<Attribute>& attribute, std::size_t element) {
  if (!attribute) return;
  const std::size_t n = static_cast<std::size_t>(attribute->components);
  for (std::size_t c = 0; c < n; ++c) {
    const double value = attribute->values[element * n + c];
    text += ' ';
    if (attribute->type == NumberType::float32 && fits_float(value)) {
      append_real(text, static_cast<float>(value));
    } else {
      append_real(text, value);
    }
  }
}

// A real number has a point or an exponent, so that it is not read as one of 0 to 255.
void append_color(std::string& text, const Attribute& color, std::size_t element) {
  const std::size_t n = static_cast<std::size_t>(color.components);
  for (std::size_t c = 0; c < n; ++c) {
    const double value =
        color.values[element * n + c] * (color.type == NumberType::uint16 ? unit_scale(color.type) : 1);
    text += ' ';
    const std::size_t begin = text.size();
    if (color.type != NumberType::float64 && fits_float(value)) {
      append_real(text, static_cast<float>(value));
    } else {
      append_real(text, value);
    }
    const bool is_real = color.type != NumberType::uint8 && color.type != NumberType::int32;
    if (is_real && text.find_first_of(".e", begin) == std::string::npos) text += ".0";
  }
}

void append_vertex(std::string& text, const Mesh& mesh, const Holdings& held, std::size_t i,
                   std::optional<int> decimals) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis > 0) text += ' ';
    append_decimals(text, mesh.positions[i][axis], decimals);
  }
  append_numbers(text, held.normal, i);
  if (held.color) {
    append_color(text, *held.color, i);
    // COFF means four numbers: OpenMesh and assimp read past the line of a vertex with three.
    if (held.color->components == 3) text += held.color->type == NumberType::uint8 ? " 255" : " 1.0";
  }
  append_numbers(text, held.uv, i);
  text += '\n';
}

}  // namespace

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  const Holdings held = sort_attributes(mesh);
  std::string text = held.uv ? "ST" : "";
  if (held.color) text += 'C';
  if (held.normal) text += 'N';
  text += "OFF\n" + std::to_string(mesh.vertex_count()) + ' ' + std::to_string(mesh.face_count()) + " 0\n";
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) append_vertex(text, mesh, held, i, options.decimals);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    text += std::to_string(mesh.face(f).size());
    for (const std::uint32_t v : mesh.face(f)) text += ' ' + std::to_string(v);
    if (held.face_color != nullptr) append_color(text, *held.face_color, f);
    text += '\n';
  }
  return text;
}

std::vector<std::string> losses(const Mesh& mesh) {
  const Holdings held = sort_attributes(mesh);
  std::vector<std::string> losses;
  for (const Attribute& attribute : mesh.attributes) {
    if (held.holds(attribute)) continue;
    losses.push_back("OFF cannot hold '" + attribute.name + "'" +
                     (attribute.domain == Domain::face ? " per face" : ""));
  }
  return losses;
}

}  // namespace knead::io_detail::off
