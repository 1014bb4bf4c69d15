// Vertex normals, and the transport of authored normals and tangents by a deformation.
#include "knead/mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "knead/error.h"
#include "math/elementary.h"
#include "mesh/edges.h"

namespace knead {
namespace {

Vec3d unit_or_zero(const Vec3d& v) {
  const double largest = std::fmax(std::abs(v.x), std::fmax(std::abs(v.y), std::abs(v.z)));
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  return normalized(v / largest);  // scaled first: squares must neither overflow nor underflow
}

// Calls visit(corner, normal times angle) for every corner of every face that has an area.
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
    visit(mesh.face_begin[f] + i, normal * elementary::atan2(norm(cross(a, b)), dot(a, b)));
  }
}

bool any_moved(std::span<const std::uint32_t> face, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  for (const std::uint32_t v : face) {
    if (!(before[v] == after[v])) return true;
  }
  return false;
}

// Returns a flag for each authored normal: true if a vertex of its faces moved.
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

// Returns `count` mean normals: number i is the mean at the corners for which number_of(corner) is i.
template <class NumberOf>
std::vector<Vec3d> mean_normals(const Mesh& mesh, std::span<const Vec3d> positions, std::size_t count,
                                const NumberOf& number_of) {
  std::vector<Vec3d> means(count);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    bool needed = false;
    for (std::size_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
      needed = needed || number_of(c) != kNoNormal;
    }
    if (!needed) continue;
    for_each_corner_normal(mesh, positions, f, [&](std::size_t c, const Vec3d& weighted) {
      const std::uint32_t number = number_of(c);
      if (number != kNoNormal) means[number] += weighted;
    });
  }
  for (Vec3d& mean : means) mean = unit_or_zero(mean);
  return means;
}

// Returns the mean normal of the corners of each touched authored normal; zero for the others.
std::vector<Vec3d> mean_normals(const Mesh& mesh, std::span<const Vec3d> positions, const std::vector<bool>& touched,
                                std::span<const std::uint32_t> corner_normal) {
  return mean_normals(mesh, positions, touched.size(), [&](std::size_t c) {
    return corner_normal[c] != kNoNormal && touched[corner_normal[c]] ? corner_normal[c] : kNoNormal;
  });
}

// Returns v rotated by the smallest rotation that maps the unit vector a to the unit vector b (Rodrigues).
Vec3d rotate_between(const Vec3d& v, const Vec3d& a, const Vec3d& b) {
  const Vec3d axis = cross(a, b);
  const double cosine = dot(a, b);
  if (cosine < -1 + 1e-14) {  // opposite: half a turn about any orthogonal axis
    const Vec3d u = any_orthogonal(a);
    return u * (2 * dot(u, v)) - v;
  }
  return v * cosine + cross(axis, v) + axis * (dot(axis, v) / (1 + cosine));
}

// Returns the angle by which the surface around an authored normal turns about its mean normal, after the smallest
// rotation that maps the mean from before to after. The angle is given by the sums of the sines and cosines of its
// edges.
struct Turn {
  double sine = 0;
  double cosine = 0;

  // Rotates a vector about the unit vector `axis`. A vector along the axis keeps its bits.
  Vec3d turned(const Vec3d& v, const Vec3d& axis) const {
    const double size = elementary::hypot(sine, cosine);
    if (!(size > 0)) return v;
    const Vec3d across = v - axis * dot(axis, v);
    return v + across * (cosine / size - 1) + cross(axis, v) * (sine / size);
  }
};

std::vector<Turn> turns_about(const Mesh& mesh, std::span<const Vec3d> after,
                              std::span<const std::uint32_t> corner_normal, const std::vector<Vec3d>& from,
                              const std::vector<Vec3d>& to) {
  std::vector<Turn> turns(from.size());
  const auto add_edge = [&](std::uint32_t normal, std::uint32_t a, std::uint32_t b) {
    if (normal == kNoNormal || from[normal] == Vec3d{} || to[normal] == Vec3d{}) return;
    const Vec3d e = unit_or_zero(mesh.positions[b] - mesh.positions[a]);
    const Vec3d f = unit_or_zero(after[b] - after[a]);
    const Vec3d& axis = to[normal];
    const Vec3d across = rotate_between(e - from[normal] * dot(from[normal], e), from[normal], axis);
    turns[normal].sine += dot(axis, cross(across, f));
    turns[normal].cosine += dot(across, f);
  };
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::size_t next = i + 1 < face.size() ? i + 1 : 0;
      add_edge(corner_normal[mesh.face_begin[f] + i], face[i], face[next]);
      add_edge(corner_normal[mesh.face_begin[f] + next], face[next], face[i]);
    }
  }
  return turns;
}

// The surface at a vertex before and after: unit normals, and the linear map B with f = B (u.e, v.e) that fits the
// edges e before and f after. The unit vectors u, v span the tangent plane before.
struct EdgeFit {
  Vec3d before;
  Vec3d after;
  Vec3d u;
  Vec3d v;
  double uu = 0;
  double uv = 0;
  double vv = 0;
  Vec3d fu;
  Vec3d fv;

  void add_edge(const Vec3d& e, const Vec3d& f) {
    const double size = norm(e);
    if (!(size > 0)) return;
    const double a = dot(u, e) / size;
    const double b = dot(v, e) / size;
    uu += a * a;
    uv += a * b;
    vv += b * b;
    fu += f * (a / size);
    fv += f * (b / size);
  }

  // Returns the mapped tangent; the tangent itself if there is no fit. Edges that leave the tangent plane tilt the
  // columns of B, so the components along the new normal are dropped; the tangent's component along the old normal
  // replaces them.
  Vec3d carried(const Vec3d& tangent) const {
    constexpr double kMinDeterminant = 1e-12;  // of a fit, relative to the squares of its edges
    const double determinant = uu * vv - uv * uv;
    if (!(determinant > kMinDeterminant * (uu + vv) * (uu + vv))) return tangent;
    const double a = dot(u, tangent);
    const double b = dot(v, tangent);
    const Vec3d moved = fu * ((a * vv - b * uv) / determinant) + fv * ((b * uu - a * uv) / determinant);
    return moved - after * dot(after, moved) + after * dot(before, tangent);
  }
};

std::vector<EdgeFit> fit_edges(const Mesh& mesh, std::span<const Vec3d> positions, const std::vector<bool>& touched) {
  const std::vector<Vec3d> before = mean_normals(mesh, mesh.positions, touched, mesh.corner_vertex);
  const std::vector<Vec3d> after = mean_normals(mesh, positions, touched, mesh.corner_vertex);
  std::vector<EdgeFit> fits(mesh.vertex_count());
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (before[i] == Vec3d{} || after[i] == Vec3d{}) continue;
    const Vec3d u = any_orthogonal(before[i]);
    fits[i] = {before[i], after[i], u, cross(before[i], u), 0, 0, 0, {}, {}};
  }
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint32_t a = face[i];
      const std::uint32_t b = face[i + 1 < face.size() ? i + 1 : 0];
      if (touched[a]) fits[a].add_edge(mesh.positions[b] - mesh.positions[a], positions[b] - positions[a]);
      if (touched[b]) fits[b].add_edge(mesh.positions[a] - mesh.positions[b], positions[a] - positions[b]);
    }
  }
  return fits;
}

}  // namespace

std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions) {
  require_faces(mesh, positions);
  std::vector<Vec3d> normals(mesh.vertex_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for_each_corner_normal(mesh, positions, f,
                           [&](std::size_t c, const Vec3d& weighted) { normals[mesh.corner_vertex[c]] += weighted; });
  }
  for (Vec3d& normal : normals) normal = unit_or_zero(normal);
  return normals;
}

std::vector<Vec3d> vertex_normals(const Mesh& mesh) { return vertex_normals(mesh, mesh.positions); }

std::vector<Vec3d> vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions, const std::vector<bool>& needed) {
  require_faces(mesh, positions);
  if (needed.size() != mesh.vertex_count()) throw InvalidInput("give a flag for each vertex");
  return mean_normals(mesh, positions, needed, mesh.corner_vertex);
}

std::vector<Vec3d> normals_of(const Mesh& mesh, std::span<const Vec3d> positions,
                              std::span<const std::uint32_t> vertices) {
  std::vector<bool> needed(mesh.vertex_count(), false);
  for (const std::uint32_t v : vertices) needed[v] = true;
  return mean_normals(mesh, positions, vertices.size(), [&](std::size_t c) {
    const std::uint32_t v = mesh.corner_vertex[c];
    if (!needed[v]) return kNoNormal;
    return static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
  });
}

std::vector<Vec3d> transport_normals(const Mesh& mesh, std::span<const Vec3d> after, std::span<const Vec3d> normals,
                                     std::span<const std::uint32_t> corner_normal) {
  require_sound(mesh, after);
  if (corner_normal.size() != mesh.corner_vertex.size()) throw InvalidInput("name a normal for each corner");
  for (std::size_t c = 0; c < corner_normal.size(); ++c) {
    if (corner_normal[c] == kNoNormal || corner_normal[c] < normals.size()) continue;
    throw InvalidInput("corner " + std::to_string(c) + " names normal " + std::to_string(corner_normal[c]) + " of " +
                       std::to_string(normals.size()));
  }
  std::vector<Vec3d> result(normals.begin(), normals.end());
  const std::vector<bool> touched = touched_normals(mesh, after, normals.size(), corner_normal);
  const std::vector<Vec3d> from = mean_normals(mesh, mesh.positions, touched, corner_normal);
  const std::vector<Vec3d> to = mean_normals(mesh, after, touched, corner_normal);
  const std::vector<Turn> turns = turns_about(mesh, after, corner_normal, from, to);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (from[i] == Vec3d{} || to[i] == Vec3d{}) continue;
    if (!(from[i] == to[i])) result[i] = rotate_between(result[i], from[i], to[i]);
    result[i] = turns[i].turned(result[i], to[i]);
  }
  return result;
}

std::vector<Vec3d> transport_tangents(const Mesh& mesh, std::span<const Vec3d> after, std::span<const Vec3d> tangents,
                                      std::span<const Vec3d> normals) {
  require_sound(mesh, after);
  if (tangents.size() != mesh.vertex_count() || normals.size() != mesh.vertex_count()) {
    throw InvalidInput("give a tangent and a normal for each vertex");
  }
  std::vector<Vec3d> result(tangents.begin(), tangents.end());
  const std::vector<bool> touched = touched_normals(mesh, after, tangents.size(), mesh.corner_vertex);
  const std::vector<EdgeFit> fits = fit_edges(mesh, after, touched);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (!touched[i]) continue;
    const Vec3d carried = unit_or_zero(fits[i].carried(tangents[i]));
    const Vec3d normal = unit_or_zero(normals[i]);
    const Vec3d moved = unit_or_zero(carried - normal * dot(normal, carried));
    if (!(moved == Vec3d{})) result[i] = moved;
  }
  return result;
}

}  // namespace knead
