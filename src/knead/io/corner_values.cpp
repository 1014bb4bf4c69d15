#include "knead/io/corner_values.h"

#include <algorithm>

namespace knead::io_detail {

std::optional<Attribute> merge_corners(const Mesh& mesh, const Attribute& attribute) {
  const std::size_t n = static_cast<std::size_t>(attribute.components);
  Attribute merged{attribute.name, Domain::vertex, attribute.type, attribute.components, {}};
  merged.values.resize(mesh.vertex_count() * n, 0.0);
  std::vector<bool> known(mesh.vertex_count(), false);
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    const double* from = attribute.values.data() + c * n;
    double* to = merged.values.data() + mesh.corner_vertex[c] * n;
    if (known[mesh.corner_vertex[c]] && !std::equal(from, from + n, to)) return std::nullopt;
    std::copy(from, from + n, to);
    known[mesh.corner_vertex[c]] = true;
  }
  return merged;
}

std::optional<Attribute> vertex_attribute(const Mesh& mesh, const std::string& name, int components) {
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.name != name || attribute.components != components) continue;
    if (attribute.domain == Domain::vertex) return attribute;
    if (attribute.domain != Domain::corner) continue;
    if (std::optional<Attribute> merged = merge_corners(mesh, attribute)) return merged;
  }
  return std::nullopt;
}

}  // namespace knead::io_detail
