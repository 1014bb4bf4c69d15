// Several meshes as one (JoinedMeshes); several vertices at one place as one (WeldedMesh).
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/edges.h"

namespace knead {

namespace {

// Returns the attribute for `count` elements: its values begin at element `before`, all others are 0.
Attribute widened(const Attribute& attribute, std::size_t before, std::size_t count) {
  Attribute result{attribute.name, attribute.domain, attribute.type, attribute.components, {}};
  const auto numbers = static_cast<std::size_t>(attribute.components);
  result.values.assign(numbers * count, 0);
  std::copy(attribute.values.begin(), attribute.values.end(),
            result.values.begin() + static_cast<std::ptrdiff_t>(numbers * before));
  return result;
}

// Returns the attribute at the chosen elements.
Attribute chosen_of(const Attribute& attribute, std::span<const std::uint32_t> elements) {
  Attribute result{attribute.name, attribute.domain, attribute.type, attribute.components, {}};
  const auto numbers = static_cast<std::size_t>(attribute.components);
  result.values.reserve(numbers * elements.size());
  for (const std::uint32_t e : elements) {
    for (std::size_t k = 0; k < numbers; ++k) result.values.push_back(attribute.values[numbers * e + k]);
  }
  return result;
}

}  // namespace

JoinedMeshes::JoinedMeshes(std::span<const Mesh* const> meshes) {
  std::size_t vertices = 0;
  std::size_t corners = 0;
  for (const Mesh* mesh : meshes) {
    vertices += mesh->vertex_count();
    corners += mesh->corner_vertex.size();
  }
  if (std::max(vertices, corners) >= std::numeric_limits<std::uint32_t>::max()) {
    throw InvalidInput("together the shapes have too many vertices or corners; take fewer of them at once");
  }
  mesh_.positions.reserve(vertices);
  mesh_.corner_vertex.reserve(corners);
  begins_.push_back({});
  for (const Mesh* mesh : meshes) {
    const std::uint32_t vertex = begins_.back().vertex;
    const auto corner = static_cast<std::uint32_t>(mesh_.corner_vertex.size());
    mesh_.positions.insert(mesh_.positions.end(), mesh->positions.begin(), mesh->positions.end());
    for (const std::uint32_t v : mesh->corner_vertex) mesh_.corner_vertex.push_back(vertex + v);
    for (std::size_t f = 1; f < mesh->face_begin.size(); ++f) mesh_.face_begin.push_back(corner + mesh->face_begin[f]);
    begins_.push_back({static_cast<std::uint32_t>(mesh_.vertex_count()), static_cast<std::uint32_t>(mesh_.face_count()),
                       begins_.back().attribute + static_cast<std::uint32_t>(mesh->attributes.size())});
  }
  for (std::size_t part = 0; part < meshes.size(); ++part) {
    const Begin& begin = begins_[part];
    const std::array<std::size_t, 3> before{begin.vertex, mesh_.face_begin[begin.face], begin.face};
    for (const Attribute& attribute : meshes[part]->attributes) {
      mesh_.attributes.push_back(widened(attribute, before[static_cast<std::size_t>(attribute.domain)],
                                         mesh_.element_count(attribute.domain)));
    }
  }
}

MeshPart JoinedMeshes::part_of(std::size_t part, const Mesh& remeshed, std::span<const std::uint32_t> face_source,
                               std::span<const std::uint32_t> vertex_source) const {
  if (face_source.size() != remeshed.face_count() || vertex_source.size() != remeshed.vertex_count() ||
      remeshed.attributes.size() != mesh_.attributes.size()) {
    throw InvalidInput("the remeshed mesh does not belong to the joined ones");
  }
  const Begin& begin = begins_[part];
  const Begin& end = begins_[part + 1];
  std::array<std::vector<std::uint32_t>, 3> chosen;  // vertices, corners and faces
  auto& [vertices, corners, faces] = chosen;
  std::vector<bool> has_face(remeshed.vertex_count(), false);
  std::vector<bool> is_ours(remeshed.vertex_count(), false);
  for (std::uint32_t f = 0; f < remeshed.face_count(); ++f) {
    const bool is_our_face = face_source[f] >= begin.face && face_source[f] < end.face;
    if (is_our_face) faces.push_back(f);
    for (const std::uint32_t v : remeshed.face(f)) {
      has_face[v] = true;
      if (is_our_face) is_ours[v] = true;
    }
  }
  std::vector<std::uint32_t> number(remeshed.vertex_count(), 0);
  MeshPart result;
  for (std::uint32_t v = 0; v < remeshed.vertex_count(); ++v) {
    const bool is_loose = !has_face[v] && vertex_source[v] >= begin.vertex && vertex_source[v] < end.vertex;
    if (!is_ours[v] && !is_loose) continue;
    number[v] = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(v);
    result.mesh.positions.push_back(remeshed.positions[v]);
  }
  for (const std::uint32_t f : faces) {
    result.face_source.push_back(face_source[f] - begin.face);
    for (std::uint32_t c = remeshed.face_begin[f]; c < remeshed.face_begin[f + 1]; ++c) {
      corners.push_back(c);
      result.mesh.corner_vertex.push_back(number[remeshed.corner_vertex[c]]);
    }
    result.mesh.face_begin.push_back(static_cast<std::uint32_t>(result.mesh.corner_vertex.size()));
  }
  for (std::uint32_t a = begin.attribute; a < end.attribute; ++a) {
    const Attribute& attribute = remeshed.attributes[a];
    result.mesh.attributes.push_back(chosen_of(attribute, chosen[static_cast<std::size_t>(attribute.domain)]));
  }
  return result;
}

std::size_t JoinedMeshes::part_of_face(std::uint32_t face) const {
  const auto after = std::upper_bound(begins_.begin(), begins_.end(), face,
                                      [](std::uint32_t f, const Begin& begin) { return f < begin.face; });
  return static_cast<std::size_t>(after - begins_.begin()) - 1;
}

std::size_t count_between(const SelfIntersections& found, const JoinedMeshes& joined,
                          std::span<const std::uint32_t> triangle_source) {
  if (!found.complete) throw InvalidInput("too many pairs of triangles cross to be counted");
  return static_cast<std::size_t>(std::count_if(found.pairs.begin(), found.pairs.end(), [&](const auto& pair) {
    return joined.part_of_face(triangle_source[pair[0]]) != joined.part_of_face(triangle_source[pair[1]]);
  }));
}

WeldedMesh::WeldedMesh(const Mesh& mesh) : given_(&mesh) {
  require_faces(mesh, mesh.positions);
  if (is_closed_and_oriented(mesh)) return;  // most meshes are, and this test is fast
  std::vector<bool> is_border(mesh.vertex_count(), false);
  for_each_edge(mesh, [&](std::span<const EdgeUse> uses) {
    if (uses.size() == 1) is_border[uses[0].low] = is_border[uses[0].high] = true;
  });
  std::vector<std::uint32_t> border;
  for (std::uint32_t v = 0; v < is_border.size(); ++v) {
    if (is_border[v]) border.push_back(v);
  }
  const auto key = [&](std::uint32_t v) {
    const Vec3d& p = mesh.positions[v];
    return std::tuple(p.x, p.y, p.z, v);
  };
  std::sort(border.begin(), border.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  std::vector<std::uint32_t> first(mesh.vertex_count());
  std::iota(first.begin(), first.end(), 0U);
  for (std::size_t i = 1; i < border.size(); ++i) {
    if (mesh.positions[border[i]] != mesh.positions[border[i - 1]]) continue;
    first[border[i]] = first[border[i - 1]];
    ++count_;
  }
  if (count_ == 0) return;
  first_ = std::move(first);
  own_.emplace(Mesh{mesh.positions, mesh.face_begin, mesh.corner_vertex, {}});
  for (std::uint32_t& v : own_->corner_vertex) v = first_[v];
}

}  // namespace knead
