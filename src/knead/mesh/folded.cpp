// Counting folded edges.
#include <numbers>

#include "knead/math/elementary.h"
#include "knead/mesh/edges.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/triangulate.h"

namespace knead {
namespace {

Mesh triangles_of(const Mesh& mesh) {
  Mesh result;
  result.positions = mesh.positions;
  for (const Triangle& t : triangulate(mesh)) result.add_face(t);
  return result;
}

// Returns a normal, not of unit length; zero for a triangle without area.
Vec3d normal_of(const Mesh& mesh, std::uint32_t triangle) {
  const std::span<const std::uint32_t> t = mesh.face(triangle);
  const Vec3d& a = mesh.positions[t[0]];
  const Vec3d& b = mesh.positions[t[1]];
  const Vec3d& c = mesh.positions[t[2]];
  return is_degenerate(a, b, c) ? Vec3d{} : cross(b - a, c - a);
}

}  // namespace

std::size_t count_folded_edges(const Mesh& mesh) {
  const double cosine = elementary::cos(170 * std::numbers::pi / 180);
  const Mesh triangles = triangles_of(mesh);
  std::size_t folded = 0;
  for_each_edge(triangles, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2 || edge[0].upward == edge[1].upward) return;
    const Vec3d n = normal_of(triangles, edge[0].corner / 3);
    const Vec3d m = normal_of(triangles, edge[1].corner / 3);
    if (dot(n, m) < cosine * norm(n) * norm(m)) ++folded;
  });
  return folded;
}

}  // namespace knead
