// Writing a mesh as a new OBJ file.
#include <array>
#include <bit>
#include <unordered_map>

#include "knead/io/obj.h"
#include "knead/io/text.h"

namespace knead {
namespace {

void append_vector(std::string& text, const char* keyword, const double* values, std::size_t n) {
  text += keyword;
  for (std::size_t i = 0; i < n; ++i) {
    text += ' ';
    append_real(text, values[i]);
  }
}

// The values of an attribute as lines `vt` or `vn`, each value once, and which line each corner uses.
struct Lines {
  std::string text;
  std::vector<std::size_t> corner_line;  // from 1; empty: the attribute is absent
};

template <std::size_t N>
struct HashBits {
  std::size_t operator()(const std::array<double, N>& values) const {
    std::uint64_t hash = 0;
    for (const double value : values)
      hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x9e3779b97f4a7c15u + (hash >> 29);
    return static_cast<std::size_t>(hash ^ (hash >> 32));
  }
};

template <std::size_t N>
Lines lines_of(const Mesh& mesh, const char* attribute_name, const char* keyword) {
  Lines lines;
  const Attribute* attribute = mesh.find_attribute(attribute_name);
  if (attribute == nullptr || attribute->components != N || attribute->domain == Domain::face) return lines;
  std::unordered_map<std::array<double, N>, std::size_t, HashBits<N>> known;
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    const std::size_t element = attribute->domain == Domain::corner ? c : mesh.corner_vertex[c];
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = attribute->values[element * N + i];
    const auto [entry, is_new] = known.try_emplace(values, known.size() + 1);
    if (is_new) {
      append_vector(lines.text, keyword, values.data(), N);
      lines.text += '\n';
    }
    lines.corner_line.push_back(entry->second);
  }
  return lines;
}

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

void append_vertices(std::string& text, const Mesh& mesh) {
  const Attribute* color = vertex_color(mesh);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const Vec3d& p = mesh.positions[i];
    const std::array<double, 3> xyz{p.x, p.y, p.z};
    append_vector(text, "v", xyz.data(), 3);
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

std::string generate_obj(const Mesh& mesh, const WriteOptions&) {
  const Lines uv = lines_of<2>(mesh, "uv", "vt");
  const Lines normal = lines_of<3>(mesh, "normal", "vn");
  std::string text;
  append_vertices(text, mesh);
  text += uv.text;
  text += normal.text;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) append_face(text, mesh, f, uv, normal);
  return text;
}

std::vector<std::string> obj_losses(const Mesh& mesh) {
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

std::vector<std::string> obj_source_losses(const ShapeFile& source) {
  std::vector<std::string> losses;
  for (const std::string& keyword : std::get<ObjLayout>(source.layout).other_keywords) {
    losses.push_back("lines '" + keyword + "' are left out");
  }
  return losses;
}

}  // namespace knead
