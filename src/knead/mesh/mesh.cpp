#include "knead/mesh/mesh.h"

#include <fmt/format.h>

#include <algorithm>

#include "knead/math/error.h"
#include "knead/mesh/check.h"

namespace knead {

namespace {

void check_faces(const Mesh& mesh) {
  const auto& begin = mesh.face_begin;
  if (begin.empty() || begin.front() != 0) throw InvalidInput("a mesh's \"face_begin\" must begin with 0");
  for (std::size_t f = 0; f + 1 < begin.size(); ++f) {
    if (begin[f] > begin[f + 1]) {
      throw InvalidInput(fmt::format("face {} of a mesh begins after it ends; let \"face_begin\" never decrease", f));
    }
  }
  if (begin.back() != mesh.corner_vertex.size()) {
    throw InvalidInput(
        fmt::format("the last face of a mesh ends at corner {} of {}; let \"face_begin\" end with their "
                    "number",
                    begin.back(), mesh.corner_vertex.size()));
  }
  std::uint32_t largest = 0;
  for (const std::uint32_t v : mesh.corner_vertex) largest = std::max(largest, v);
  if (mesh.corner_vertex.empty() || largest < mesh.positions.size()) return;
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    if (mesh.corner_vertex[c] < mesh.positions.size()) continue;
    throw InvalidInput(fmt::format("corner {} of a mesh names vertex {}, but there are only {} vertices; correct it", c,
                                   mesh.corner_vertex[c], mesh.positions.size()));
  }
}

void check_places(std::span<const Vec3d> positions) {
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (is_finite(positions[v])) continue;
    throw InvalidInput(fmt::format("vertex {} of a mesh has a coordinate that is not finite; place or remove it", v));
  }
}

std::size_t elements(const Mesh& mesh, Domain domain) {
  switch (domain) {
    case Domain::vertex:
      return mesh.vertex_count();
    case Domain::corner:
      return mesh.corner_vertex.size();
    case Domain::face:
      break;
  }
  return mesh.face_count();
}

}  // namespace

void require_faces(const Mesh& mesh, std::span<const Vec3d> positions) {
  check_faces(mesh);
  if (positions.size() != mesh.vertex_count()) {
    throw InvalidInput(fmt::format("{} positions for a mesh of {} vertices; give one for each", positions.size(),
                                   mesh.vertex_count()));
  }
}

void require_sound(const Mesh& mesh, std::span<const Vec3d> positions) {
  require_faces(mesh, positions);
  check_places(positions);
}

void validate(const Mesh& mesh) {
  require_sound(mesh, mesh.positions);
  for (const Attribute& attribute : mesh.attributes) {
    const std::size_t count = elements(mesh, attribute.domain);
    if (attribute.components > 0 && attribute.values.size() == count * static_cast<std::size_t>(attribute.components)) {
      continue;
    }
    throw InvalidInput(fmt::format("the attribute \"{}\" of a mesh has {} numbers for {} elements of {} components",
                                   attribute.name, attribute.values.size(), count, attribute.components));
  }
}

}  // namespace knead
