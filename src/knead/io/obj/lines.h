// Lines `vt` and `vn` of a new OBJ file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/math/scalar.h"
#include "knead/mesh/mesh.h"

namespace knead::io_detail::obj {

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

}  // namespace knead::io_detail::obj
