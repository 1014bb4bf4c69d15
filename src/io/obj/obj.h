// Wavefront OBJ: the words of its lines, and what a file holds besides a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "io/codec.h"
#include "io/numbers.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail::obj {

void read(ShapeFile& shape, const std::string& name);
std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> remesh_losses(const ShapeFile& source);
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// The byte at which the lines begin: after a byte order mark.
std::size_t first_byte(std::string_view bytes);

// The first byte at or after `position` on the same line that is no blank; a backslash at the end of a line joins the
// next line to it.
std::size_t skip_blanks(std::string_view bytes, std::size_t position);

// The line end at or after `position`, or the end of the text.
std::size_t end_of_line(std::string_view bytes, std::size_t position);

// The byte after the token that begins at `position`.
std::size_t word_end(std::string_view bytes, std::size_t position);

// The part of an OBJ file that a mesh does not hold.
struct Layout {
  std::vector<Vec3d> normals;                // the value of each vn
  std::vector<std::uint32_t> corner_normal;  // which vn each corner of the mesh uses, or kNoNormal; empty: none does
  bool normals_ahead = false;                // whether a face stands before a vn that it uses
  std::vector<std::string> material_files;   // what `mtllib` lines name: each line's words, and each line as a whole
  std::vector<std::uint32_t> unplaced;  // lines `v`, counted from 0, of vertices that the mesh lacks (mesh_builder.h)
  std::vector<std::string> other_keywords;  // of the lines that a mesh does not hold, e.g. "usemtl"; each once
};

// Lines `vt` and `vn` of a new OBJ file.

inline void append_vector(std::string& text, const char* keyword, const double* values, std::size_t n,
                          std::optional<int> decimals = std::nullopt) {
  text += keyword;
  for (std::size_t i = 0; i < n; ++i) {
    text += ' ';
    append_decimals(text, values[i], decimals);
  }
}

// The values of an attribute as lines, each value once, and which line each corner uses.
struct Lines {
  std::string text;
  std::vector<std::size_t> corner_line;  // from 1; 0: none. Empty: the attribute is absent
};

template <std::size_t N>
struct HashBits {
  std::size_t operator()(const std::array<double, N>& values) const {
    std::uint64_t hash = 0;
    for (const double value : values)
      hash = (hash ^ bit_cast<std::uint64_t>(value)) * 0x9e3779b97f4a7c15u + (hash >> 29);
    return static_cast<std::size_t>(hash ^ (hash >> 32));
  }
};

// Of the attribute of that name with N components, of corners or vertices; of the corners for which is_used says so.
template <std::size_t N, class IsUsed>
Lines value_lines(const Mesh& mesh, const char* attribute_name, const char* keyword, std::string_view line_end,
                  IsUsed is_used) {
  Lines lines;
  const Attribute* attribute = mesh.find_attribute(attribute_name);
  if (attribute == nullptr || attribute->components != N || attribute->domain == Domain::face) return lines;
  std::unordered_map<std::array<double, N>, std::size_t, HashBits<N>> known;
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    const std::size_t element = attribute->domain == Domain::corner ? c : mesh.corner_vertex[c];
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = attribute->values[element * N + i];
    lines.corner_line.push_back(0);
    if (!is_used(c, values)) continue;
    const auto [entry, is_new] = known.try_emplace(values, known.size() + 1);
    if (is_new) {
      append_vector(lines.text, keyword, values.data(), N);
      lines.text += line_end;
    }
    lines.corner_line.back() = entry->second;
  }
  return lines;
}

template <std::size_t N>
Lines value_lines(const Mesh& mesh, const char* attribute_name, const char* keyword) {
  return value_lines<N>(mesh, attribute_name, keyword, "\n", [](std::size_t, const auto&) { return true; });
}

}  // namespace knead::detail::obj
