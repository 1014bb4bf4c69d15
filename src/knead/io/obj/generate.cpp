// Writing a mesh as a new OBJ file.
#include <array>

#include "knead/io/layout.h"
#include "knead/io/obj/layout.h"
#include "knead/io/obj/lines.h"
#include "knead/io/obj/obj.h"
#include "knead/io/text.h"
#include "knead/io/unplaced.h"

namespace knead::io_detail::obj {
namespace {

// Colors as OBJ has them: 0 to 1.
double color_scale(const Attribute& color) {
  if (color.type == NumberType::uint8) return 1.0 / 255;
  return color.type == NumberType::uint16 ? 1.0 / 65535 : 1.0;
}

const Attribute* vertex_color(const Mesh& mesh) {
  const Attribute* color = mesh.find_attribute("color");
  return color != nullptr && color->domain == Domain::vertex && color->components >= 3 ? color : nullptr;
}

// Colors are floats where they come from, and shorter as such.
void append_color(std::string& text, double value) {
  if (fits_float(value)) {
    append_real(text, static_cast<float>(value));
  } else {
    append_real(text, value);
  }
}

void append_vertices(std::string& text, const Mesh& mesh, std::optional<int> decimals) {
  const Attribute* color = vertex_color(mesh);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const Vec3d& p = mesh.positions[i];
    const std::array<double, 3> xyz{p.x, p.y, p.z};
    append_vector(text, "v", xyz.data(), 3, decimals);
    for (std::size_t c = 0; color != nullptr && c < 3; ++c) {
      text += ' ';
      const std::size_t first = i * static_cast<std::size_t>(color->components);
      append_color(text, color->values[first + c] * color_scale(*color));
    }
    text += '\n';
  }
}

void append_face(std::string& text, const Mesh& mesh, std::size_t f, const Lines& uv, const Lines& normal) {
  text += 'f';
  for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
    text += ' ' + std::to_string(mesh.corner_vertex[c] + std::size_t{1});
    if (uv.corner_line.empty() && normal.corner_line.empty()) continue;
    text += '/';
    if (!uv.corner_line.empty()) text += std::to_string(uv.corner_line[c]);
    if (!normal.corner_line.empty()) text += '/' + std::to_string(normal.corner_line[c]);
  }
  text += '\n';
}

}  // namespace

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  const Lines uv = value_lines<2>(mesh, "uv", "vt");
  const Lines normal = value_lines<3>(mesh, "normal", "vn");
  std::string text;
  append_vertices(text, mesh, options.decimals);
  text += uv.text;
  text += normal.text;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) append_face(text, mesh, f, uv, normal);
  return text;
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  for (const Attribute& attribute : mesh.attributes) {
    const bool is_shading = attribute.name == "uv" || attribute.name == "normal";
    if (is_shading && attribute.domain != Domain::face && &attribute == mesh.find_attribute(attribute.name)) {
      if (mesh.face_count() == 0) losses.push_back("OBJ cannot hold '" + attribute.name + "' of points without faces");
    } else if (&attribute != vertex_color(mesh)) {
      losses.push_back("OBJ cannot hold '" + attribute.name + "'" +
                       (attribute.domain == Domain::face ? " per face" : ""));
    } else if (attribute.components > 3) {
      losses.push_back("OBJ cannot hold the alpha of colors");
    }
  }
  return losses;
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  std::vector<std::string> losses;
  for (const std::string& keyword : layout_of<Layout>(source).other_keywords) {
    losses.push_back("lines '" + keyword + "' are left out");
  }
  const std::size_t unplaced = layout_of<Layout>(source).unplaced.size();
  if (unplaced > 0) losses.push_back(unplaced_loss(unplaced));
  return losses;
}

}  // namespace knead::io_detail::obj
