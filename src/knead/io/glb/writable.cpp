#include "knead/io/glb/writable.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "knead/io/corner_values.h"
#include "knead/io/glb/attributes.h"

namespace knead::io_detail::glb {
namespace {

// "_NAME", the way that applications name their own attributes.
std::string custom_key(const std::string& name) {
  std::string key = "_";
  for (const char c : name) {
    const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    key += (upper >= 'A' && upper <= 'Z') || (upper >= '0' && upper <= '9') ? upper : '_';
  }
  return key;
}

std::string key_of(const Attribute& attribute) {
  for (const Semantic& semantic : kSemantics) {
    if (attribute.name != semantic.name) continue;
    const int n = attribute.components;
    const bool fits = attribute.name == "normal" ? n == 3 : attribute.name == "uv" ? n == 2 : n == 4;
    if (fits || (attribute.name == "color" && n == 3)) return semantic.key;
  }
  return custom_key(attribute.name);
}

bool differs_at_corners(const std::vector<WritableAttribute>& held, std::size_t a, std::size_t b) {
  return std::any_of(held.begin(), held.end(), [&](const WritableAttribute& h) {
    if (h.attribute.domain != Domain::corner) return false;
    const std::size_t n = static_cast<std::size_t>(h.attribute.components);
    const double* values = h.attribute.values.data();
    return !std::equal(values + a * n, values + (a + 1) * n, values + b * n);
  });
}

// Whether corner a comes before b: by vertex, values, number.
bool comes_before(const Mesh& mesh, const std::vector<WritableAttribute>& held, std::size_t a, std::size_t b) {
  if (mesh.corner_vertex[a] != mesh.corner_vertex[b]) return mesh.corner_vertex[a] < mesh.corner_vertex[b];
  for (const WritableAttribute& h : held) {
    if (h.attribute.domain != Domain::corner) continue;
    const std::size_t n = static_cast<std::size_t>(h.attribute.components);
    const double* values = h.attribute.values.data();
    for (std::size_t i = 0; i < n; ++i) {
      if (values[a * n + i] != values[b * n + i]) return values[a * n + i] < values[b * n + i];
    }
  }
  return a < b;
}

}  // namespace

WritableAttributes writable_attributes(const Mesh& mesh) {
  WritableAttributes held;
  std::set<std::string> keys;
  for (const Attribute& attribute : mesh.attributes) {
    const std::string key = key_of(attribute);
    std::optional<Attribute> kept = attribute;
    if (attribute.domain == Domain::corner) kept = merge_corners(mesh, attribute);
    if (!kept && key.front() != '_') kept = attribute;  // its vertices are split
    if (attribute.domain == Domain::face) {
      held.losses.push_back("GLB cannot hold '" + attribute.name + "' per face");
    } else if (!kept) {
      held.losses.push_back("GLB cannot hold '" + attribute.name + "' that differs between the faces at a vertex");
    } else if (attribute.components > 4 || !keys.insert(key).second) {
      held.losses.push_back("GLB cannot hold '" + attribute.name + "'");
    } else {
      held.attributes.push_back({key, *std::move(kept)});
    }
  }
  return held;
}

SplitVertices split_vertices(const Mesh& mesh, const std::vector<WritableAttribute>& held) {
  SplitVertices split;
  split.original.resize(mesh.vertex_count());
  std::iota(split.original.begin(), split.original.end(), 0u);
  split.corner.assign(mesh.vertex_count(), SplitVertices::kNone);
  split.corner_index = mesh.corner_vertex;
  const bool has_corners = std::any_of(held.begin(), held.end(),
                                       [](const WritableAttribute& h) { return h.attribute.domain == Domain::corner; });
  if (!has_corners) return split;
  std::vector<std::size_t> order(mesh.corner_vertex.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return comes_before(mesh, held, a, b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t c = order[i];
    const std::uint32_t v = mesh.corner_vertex[c];
    if (split.corner[v] == SplitVertices::kNone) {
      split.corner[v] = c;
    } else if (differs_at_corners(held, c, order[i - 1])) {
      split.corner_index[c] = static_cast<std::uint32_t>(split.original.size());
      split.original.push_back(v);
      split.corner.push_back(c);
      continue;
    } else {
      split.corner_index[c] = split.corner_index[order[i - 1]];
      continue;
    }
    split.corner_index[c] = v;
  }
  return split;
}

}  // namespace knead::io_detail::glb
