#include "knead/mesh/normals.h"

#include <cmath>

#include "knead/mesh/triangulate.h"

namespace knead {
namespace {

Vec3d unit_or_zero(const Vec3d& v) {
  const double largest = std::fmax(std::abs(v.x), std::fmax(std::abs(v.y), std::abs(v.z)));
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  return normalized(v / largest);  // scaled first, so that squares neither overflow nor vanish
}

// Calls visit(corner, normal times angle) for every corner of a face with an area.
template <class Visit>
void for_each_corner_normal(const Mesh& mesh, std::span<const Vec3d> positions, std::size_t f, Visit visit) {
  const std::span<const std::uint32_t> face = mesh.face(f);
  const Vec3d normal = unit_or_zero(polygon_normal(positions, face));
  if (normal == Vec3d{}) return;
  const std::size_t n = face.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d& p = positions[face[i]];
    const Vec3d a = unit_or_zero(positions[face[i + 1 < n ? i + 1 : 0]] - p);
    const Vec3d b = unit_or_zero(positions[face[i > 0 ? i - 1 : n - 1]] - p);
    visit(mesh.face_begin[f] + i, normal * std::atan2(norm(cross(a, b)), dot(a, b)));
  }
}

bool any_moved(std::span<const std::uint32_t> face, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  for (const std::uint32_t v : face) {
    if (!(before[v] == after[v])) return true;
  }
  return false;
}

// Per authored normal, whether a vertex of its faces moved.
std::vector<bool> touched_normals(const Mesh& mesh, std::span<const Vec3d> after, std::size_t normals,
                                  std::span<const std::uint32_t> corner_normal) {
  std::vector<bool> touched(normals, false);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (!any_moved(mesh.face(f), mesh.positions, after)) continue;
    for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
      if (corner_normal[c] != kNoNormal) touched[corner_normal[c]] = true;
    }
  }
  return touched;
}

// Per authored normal that was touched, the mean of the normals of its corners; zero for the others.
std::vector<Vec3d> mean_normals(const Mesh& mesh, std::span<const Vec3d> positions, const std::vector<bool>& touched,
                                std::span<const std::uint32_t> corner_normal) {
  const auto counts = [&](std::size_t c) { return corner_normal[c] != kNoNormal && touched[corner_normal[c]]; };
  std::vector<Vec3d> means(touched.size());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    bool needed = false;
    for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) needed = needed || counts(c);
    if (!needed) continue;
    for_each_corner_normal(mesh, positions, f, [&](std::size_t c, const Vec3d& weighted) {
      if (counts(c)) means[corner_normal[c]] += weighted;
    });
  }
  for (Vec3d& mean : means) mean = unit_or_zero(mean);
  return means;
}

// v turned by the smallest rotation that takes the unit vector a to the unit vector b (Rodrigues).
Vec3d rotate_between(const Vec3d& v, const Vec3d& a, const Vec3d& b) {
  const Vec3d axis = cross(a, b);
  const double cosine = dot(a, b);
  if (cosine < -1 + 1e-14) {  // opposite: half a turn about any axis across
    const Vec3d u = any_orthogonal(a);
    return u * (2 * dot(u, v)) - v;
  }
  return v * cosine + cross(axis, v) + axis * (dot(axis, v) / (1 + cosine));
}

}  // namespace

std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions) {
  std::vector<Vec3d> normals(mesh.vertex_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for_each_corner_normal(mesh, positions, f,
                           [&](std::size_t c, const Vec3d& weighted) { normals[mesh.corner_vertex[c]] += weighted; });
  }
  for (Vec3d& normal : normals) normal = unit_or_zero(normal);
  return normals;
}

std::vector<Vec3d> vertex_normals(const Mesh& mesh) { return vertex_normals(mesh, mesh.positions); }

std::vector<Vec3d> transport_normals(const Mesh& mesh, std::span<const Vec3d> after, std::span<const Vec3d> normals,
                                     std::span<const std::uint32_t> corner_normal) {
  std::vector<Vec3d> result(normals.begin(), normals.end());
  const std::vector<bool> touched = touched_normals(mesh, after, normals.size(), corner_normal);
  const std::vector<Vec3d> from = mean_normals(mesh, mesh.positions, touched, corner_normal);
  const std::vector<Vec3d> to = mean_normals(mesh, after, touched, corner_normal);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (from[i] == Vec3d{} || to[i] == Vec3d{} || from[i] == to[i]) continue;
    result[i] = rotate_between(result[i], from[i], to[i]);
  }
  return result;
}

}  // namespace knead
