#include "knead/remesh/carried_normals.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "knead/mesh/normals.h"

namespace knead::remesh_detail {

namespace {

struct Column {
  Domain domain = Domain::vertex;
  std::size_t offset = 0;  // in a row of the values of the surface
};

std::optional<Column> find_normals(const Mesh& mesh) {
  std::size_t vertex_offset = 0;
  std::size_t corner_offset = 0;
  for (const Attribute& attribute : mesh.attributes) {
    std::size_t& offset = attribute.domain == Domain::vertex ? vertex_offset : corner_offset;
    if (attribute.domain == Domain::face) continue;
    if (attribute.name == "normal" && attribute.components == 3) return Column{attribute.domain, offset};
    offset += static_cast<std::size_t>(attribute.components);
  }
  return std::nullopt;
}

Vec3d normal_of(const Values& values, std::size_t i, std::size_t offset) {
  const auto row = values.of(i);
  return {row[offset], row[offset + 1], row[offset + 2]};
}

void set_normal(Values& values, std::size_t i, std::size_t offset, const Vec3d& n) {
  const auto row = values.of(i);
  for (std::size_t axis = 0; axis < 3; ++axis) row[offset + axis] = n[axis];
}

// Gives one number to all corners at a vertex that have the same normal.
void share_corner_normals(const Surface& s, std::size_t offset, std::vector<Vec3d>& normals,
                          std::vector<std::uint32_t>& corner_normal) {
  std::vector<std::vector<std::uint32_t>> of_vertex(s.vertex_count());
  corner_normal.assign(s.corner.size(), kNoNormal);
  for (std::uint32_t c = 0; c < s.corner.size(); ++c) {
    const Vec3d n = normal_of(s.corner_values, c, offset);
    std::vector<std::uint32_t>& known = of_vertex[s.corner[c]];
    const auto found = std::find_if(known.begin(), known.end(), [&](std::uint32_t i) { return normals[i] == n; });
    if (found != known.end()) {
      corner_normal[c] = *found;
      continue;
    }
    corner_normal[c] = static_cast<std::uint32_t>(normals.size());
    known.push_back(corner_normal[c]);
    normals.push_back(n);
  }
}

}  // namespace

void turn_normals(const Mesh& mesh, Surface& s) {
  const std::optional<Column> column = find_normals(mesh);
  if (!column) return;
  Mesh refined;
  refined.positions = s.before;
  refined.corner_vertex = s.corner;
  refined.face_begin.resize(s.face_count() + 1);
  for (std::size_t f = 0; f <= s.face_count(); ++f) refined.face_begin[f] = static_cast<std::uint32_t>(3 * f);
  std::vector<Vec3d> normals;
  std::vector<std::uint32_t> corner_normal = s.corner;
  if (column->domain == Domain::vertex) {
    for (std::size_t v = 0; v < s.vertex_count(); ++v) normals.push_back(normal_of(s.vertex_values, v, column->offset));
  } else {
    share_corner_normals(s, column->offset, normals, corner_normal);
  }
  normals = transport_normals(refined, s.after, normals, corner_normal);
  if (column->domain == Domain::vertex) {
    for (std::size_t v = 0; v < s.vertex_count(); ++v) set_normal(s.vertex_values, v, column->offset, normals[v]);
  } else {
    for (std::size_t c = 0; c < s.corner.size(); ++c) {
      set_normal(s.corner_values, c, column->offset, normals[corner_normal[c]]);
    }
  }
}

void normalise_normals(const Mesh& mesh, Surface& s) {
  const std::optional<Column> column = find_normals(mesh);
  if (!column) return;
  Values& values = column->domain == Domain::vertex ? s.vertex_values : s.corner_values;
  const std::size_t count = values.stride > 0 ? values.numbers.size() / values.stride : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d n = normal_of(values, i, column->offset);
    const double length = norm(n);
    // Lengths that are 1 to the rounding of float stay.
    if (length > 0 && std::abs(length - 1) > 1e-5) set_normal(values, i, column->offset, n / length);
  }
}

}  // namespace knead::remesh_detail
