#include "knead/mesh/flipped.h"

#include <vector>

#include "knead/mesh/normals.h"
#include "knead/mesh/triangulate.h"

namespace knead {
namespace {

bool opposes(const Triangle& t, std::span<const Vec3d> positions, std::span<const Vec3d> normals) {
  const Vec3d& a = positions[t[0]];
  const Vec3d normal = cross(positions[t[1]] - a, positions[t[2]] - a);
  return dot(normal, normals[t[0]] + normals[t[1]] + normals[t[2]]) < 0;
}

}  // namespace

std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  const std::vector<Vec3d> normals_before = vertex_normals(mesh, before);
  const std::vector<Vec3d> normals_after = vertex_normals(mesh, after);
  std::size_t flipped = 0;
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.face(f).size() < 3) continue;
    triangles.clear();
    triangulate_polygon(before, mesh.face(f), triangles);
    for (const Triangle& t : triangles) {
      if (opposes(t, after, normals_after) && !opposes(t, before, normals_before)) ++flipped;
    }
  }
  return flipped;
}

}  // namespace knead
