#include "knead/mesh/measures.h"

#include <algorithm>
#include <cmath>
#include <iterator>
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

// Returns the triangles that oppose the normals of their vertices.
std::vector<Triangle> opposing(const Mesh& mesh, std::span<const Triangle> triangles,
                               std::span<const Vec3d> positions) {
  std::vector<Triangle> result;
  if (triangles.empty()) return result;
  std::vector<bool> needed(mesh.vertex_count(), false);
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) needed[v] = true;
  }
  const std::vector<Vec3d> normals = vertex_normals(mesh, positions, needed);
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(result),
               [&](const Triangle& t) { return opposes(t, positions, normals); });
  return result;
}

// Returns a flag for each vertex: true if all normals of faces and triangles around it are within 45 degrees of the
// first one, less a margin far above rounding errors. A triangle with three such vertices cannot oppose their normals:
// these are sums of face normals, each within 90 degrees of its own. Most vertices of most shapes have the flag and
// need no normal, which would cost angles.
class TameVertices {
 public:
  explicit TameVertices(std::size_t count) : first_(count), tame_(count, 1) {}

  void add(const Vec3d& normal, std::span<const std::uint32_t> vertices) {
    const double size2 = norm2(normal);
    const bool sound = size2 > 1e-140;  // the area is not 0, and fourth powers do not underflow
    for (const std::uint32_t v : vertices) {
      if (first_[v] == Vec3d{}) first_[v] = normal;
      const double along = dot(first_[v], normal);
      if (!(sound && along > 0 && along * along > 0.51 * norm2(first_[v]) * size2)) tame_[v] = 0;
    }
  }

  bool are_all(const Triangle& t) const { return tame_[t[0]] + tame_[t[1]] + tame_[t[2]] == 3; }

 private:
  std::vector<Vec3d> first_;
  std::vector<unsigned char> tame_;
};

TameVertices find_tame(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  TameVertices tame(mesh.vertex_count());
  std::vector<Triangle> parts;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    tame.add(polygon_normal(after, face), face);
    if (face.size() <= 3) continue;
    parts.clear();
    triangulate_polygon(before, face, parts);
    for (const Triangle& t : parts) tame.add(polygon_normal(after, t), t);
  }
  return tame;
}

// Returns the triangles that might oppose the normals of their vertices.
std::vector<Triangle> suspects(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  const TameVertices tame = find_tame(mesh, before, after);
  std::vector<Triangle> result;
  for_each_triangle(mesh, before, [&](const Triangle& t) {
    if (!tame.are_all(t)) result.push_back(t);
  });
  return result;
}

}  // namespace

std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  const std::vector<Triangle> candidates = opposing(mesh, suspects(mesh, before, after), after);
  return candidates.size() - opposing(mesh, candidates, before).size();
}

}  // namespace knead
