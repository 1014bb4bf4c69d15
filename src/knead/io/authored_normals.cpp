#include "knead/io/authored_normals.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "knead/io/layout.h"
#include "knead/io/obj/normals.h"
#include "knead/mesh/normals.h"

namespace knead::io_detail {
namespace {

using SeamKey = std::array<double, 9>;

SeamKey seam_key(const Vec3d& before, const Vec3d& after, const Vec3d& normal) {
  return {before.x, before.y, before.z, after.x, after.y, after.z, normal.x, normal.y, normal.z};
}

// For each vertex the first one that has its position, before and after, and its normal.
std::vector<std::uint32_t> seam_leaders(std::span<const Vec3d> before, std::span<const Vec3d> after,
                                        std::span<const Vec3d> normals) {
  const auto key = [&](std::uint32_t i) { return seam_key(before[i], after[i], normals[i]); };
  std::vector<std::uint32_t> order(before.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const SeamKey a = key(i);
    const SeamKey b = key(j);
    return a != b ? a < b : i < j;
  });
  std::vector<std::uint32_t> leaders(before.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool follows = k > 0 && key(order[k]) == key(order[k - 1]);
    leaders[order[k]] = follows ? leaders[order[k - 1]] : order[k];
  }
  return leaders;
}

std::vector<Vec3d> transport_vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions,
                                            const std::vector<Vec3d>& normals) {
  const std::vector<std::uint32_t> leaders = seam_leaders(mesh.positions, positions, normals);
  std::vector<std::uint32_t> corner_normal;
  corner_normal.reserve(mesh.corner_vertex.size());
  for (const std::uint32_t vertex : mesh.corner_vertex) corner_normal.push_back(leaders[vertex]);
  std::vector<Vec3d> moved = transport_normals(mesh, positions, normals, corner_normal);
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = moved[leaders[i]];
  return moved;
}

// The attribute "tangent" of vertices: x, y, z and a handedness.
void turn_tangents(const Mesh& before, std::span<const Vec3d> positions, std::span<const Vec3d> normals, Mesh& after) {
  for (Attribute& attribute : after.attributes) {
    if (attribute.name != "tangent" || attribute.domain != Domain::vertex || attribute.components != 4) continue;
    std::vector<Vec3d> tangents(normals.size());
    for (std::size_t i = 0; i < tangents.size(); ++i) {
      tangents[i] = {attribute.values[4 * i], attribute.values[4 * i + 1], attribute.values[4 * i + 2]};
    }
    tangents = transport_tangents(before, positions, tangents, normals);
    for (std::size_t i = 0; i < tangents.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) attribute.values[4 * i + axis] = tangents[i][axis];
    }
  }
}

}  // namespace

std::vector<Vec3d> moved_normals(const ShapeFile& source, std::span<const Vec3d> positions,
                                 const WriteOptions& options) {
  if (const obj::Layout* layout = find_layout<obj::Layout>(source)) {
    if (layout->corner_normal.empty()) return {};
    return obj::moved_corner_normals(source.mesh, *layout, positions);
  }
  const std::vector<Vec3d> normals = vertex_normals_of(source);
  if (normals.empty()) return {};
  if (source.mesh.face_count() > 0) return transport_vertex_normals(source.mesh, positions, normals);
  return {options.normals.begin(), options.normals.end()};
}

Mesh moved_mesh(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options) {
  Mesh mesh = source.mesh;
  mesh.positions.assign(positions.begin(), positions.end());
  const std::vector<Vec3d> normals = moved_normals(source, positions, options);
  if (normals.empty()) return mesh;
  if (source.format != "obj") turn_tangents(source.mesh, positions, normals, mesh);
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.name != "normal") continue;
    for (std::size_t i = 0; i < attribute.values.size() / 3; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) attribute.values[3 * i + axis] = normals[i][axis];
    }
    break;
  }
  return mesh;
}

}  // namespace knead::io_detail
