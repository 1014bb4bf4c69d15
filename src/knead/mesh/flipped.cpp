#include "knead/mesh/measures.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "knead/mesh/check.h"
#include "knead/mesh/some_normals.h"
#include "knead/mesh/triangulate.h"

namespace knead {
namespace {

bool opposes(const Triangle& t, std::span<const Vec3d> positions, const Vec3d& normals) {
  const Vec3d& a = positions[t[0]];
  return dot(cross(positions[t[1]] - a, positions[t[2]] - a), normals) < 0;
}

// Returns the triangles that oppose the normals of their vertices.
std::vector<Triangle> opposing(const Mesh& mesh, std::span<const Triangle> triangles,
                               std::span<const Vec3d> positions) {
  std::vector<Triangle> result;
  if (triangles.empty()) return result;
  std::vector<std::uint32_t> vertices;
  for (const Triangle& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const std::vector<Vec3d> normals = normals_of(mesh, positions, vertices);
  const auto normal_of = [&](std::uint32_t v) {
    return normals[static_cast<std::size_t>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin())];
  };
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(result), [&](const Triangle& t) {
    return opposes(t, positions, normal_of(t[0]) + normal_of(t[1]) + normal_of(t[2]));
  });
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
    const bool sound = size2 > 1e-140;  // the area is not 0, and squares do not underflow
    for (const std::uint32_t v : vertices) {
      if (sound && first_[v] == Vec3f{}) first_[v] = Vec3f(normal / std::sqrt(size2));
      const double along = dot(Vec3d(first_[v]), normal);
      if (!(sound && along > 0 && along * along > 0.51 * size2)) tame_[v] = 0;
    }
  }

  bool are_all(const Triangle& t) const { return tame_[t[0]] + tame_[t[1]] + tame_[t[2]] == 3; }

 private:
  std::vector<Vec3f> first_;  // unit normals
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
  require_faces(mesh, before);
  require_faces(mesh, after);
  const std::vector<Triangle> candidates = opposing(mesh, suspects(mesh, before, after), after);
  return candidates.size() - opposing(mesh, candidates, before).size();
}

}  // namespace knead
