#include "knead/render/smooth_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace knead::render {

PlacedFaces place_faces(const Mesh& mesh, const Placement& placement) {
  PlacedFaces data;
  data.positions.reserve(mesh.vertex_count());
  for (const Vec3d& p : mesh.positions) data.positions.push_back(placement.apply(p));
  data.normals.reserve(mesh.face_count());
  data.corner_face.reserve(mesh.corner_vertex.size());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    data.corner_face.insert(data.corner_face.end(), face.size(), static_cast<std::uint32_t>(f));
    const Vec3d normal = face.size() < 3 ? Vec3d{} : polygon_normal(data.positions, face);
    const double length = norm(normal);
    data.normals.push_back(length > 0 && std::isfinite(length) ? normal / length : Vec3d{});
  }
  return data;
}

std::vector<Triangle> corner_triangles(const Mesh& mesh, const PlacedFaces& faces) {
  std::vector<Triangle> result;
  result.reserve(mesh.face_count());
  std::vector<Vec3d> points;
  std::vector<std::uint32_t> local;
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (faces.normals[f] == Vec3d{}) continue;
    const std::uint32_t first = mesh.face_begin[f];
    const auto face = mesh.face(f);
    if (face.size() == 3) {
      result.push_back({first, first + 1, first + 2});
      continue;
    }
    points.clear();
    for (const std::uint32_t v : face) points.push_back(faces.positions[v]);
    local.resize(face.size());
    std::iota(local.begin(), local.end(), 0u);
    triangles.clear();
    triangulate_polygon(points, local, triangles);
    for (const Triangle& t : triangles) result.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return result;
}

std::pair<std::uint32_t, std::uint32_t> around(const Mesh& mesh, const PlacedFaces& faces, std::uint32_t corner) {
  const std::uint32_t f = faces.corner_face[corner];
  const std::uint32_t begin = mesh.face_begin[f];
  const std::uint32_t end = mesh.face_begin[f + 1];
  return {mesh.corner_vertex[corner == begin ? end - 1 : corner - 1],
          mesh.corner_vertex[corner + 1 == end ? begin : corner + 1]};
}

namespace {

// The corners at each vertex: list[begin[v]] to list[begin[v + 1]]. Corners of faces that are left out are not in it.
struct Incidence {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> list;
};

Incidence incidence(const Mesh& mesh, const PlacedFaces& data) {
  Incidence result;
  result.begin.assign(mesh.vertex_count() + 1, 0);
  const auto used = [&](std::size_t corner) { return data.normals[data.corner_face[corner]] != Vec3d{}; };
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    if (used(c)) ++result.begin[mesh.corner_vertex[c] + 1];
  }
  std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
  result.list.resize(result.begin.back());
  std::vector<std::uint32_t> next(result.begin.begin(), result.begin.end() - 1);
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    if (used(c)) result.list[next[mesh.corner_vertex[c]]++] = static_cast<std::uint32_t>(c);
  }
  return result;
}

// Sorts the corners round single vertices into smooth groups; keeps its scratch memory.
class CreaseSplitter {
 public:
  CreaseSplitter(const Mesh& mesh, const PlacedFaces& data, double crease_angle)
      : mesh_(mesh), data_(data), split_all_(crease_angle < 0), cosine_(std::cos(std::max(0.0, crease_angle))) {}

  // The group of each corner, named by one of its members (an index into corners).
  const std::vector<std::uint32_t>& groups(std::span<const std::uint32_t> corners) {
    parent_.resize(corners.size());
    std::iota(parent_.begin(), parent_.end(), 0u);
    if (split_all_) return parent_;
    neighbors_.clear();
    for (std::uint32_t i = 0; i < corners.size(); ++i) add_neighbors(corners[i], i);
    std::sort(neighbors_.begin(), neighbors_.end());
    for (std::size_t i = 1; i < neighbors_.size(); ++i) {
      if (neighbors_[i].first != neighbors_[i - 1].first) continue;
      const std::uint32_t a = neighbors_[i - 1].second;
      const std::uint32_t b = neighbors_[i].second;
      if (dot(normal(corners[a]), normal(corners[b])) >= cosine_) parent_[root(a)] = root(b);
    }
    for (std::uint32_t i = 0; i < corners.size(); ++i) parent_[i] = root(i);
    return parent_;
  }

 private:
  const Vec3d& normal(std::uint32_t corner) const { return data_.normals[data_.corner_face[corner]]; }

  void add_neighbors(std::uint32_t corner, std::uint32_t index) {
    const auto [previous, next] = around(mesh_, data_, corner);
    neighbors_.emplace_back(previous, index);
    neighbors_.emplace_back(next, index);
  }

  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  const Mesh& mesh_;
  const PlacedFaces& data_;
  bool split_all_;
  double cosine_;
  std::vector<std::uint32_t> parent_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> neighbors_;
};

}  // namespace

SmoothGroups smooth_groups(const Mesh& mesh, const PlacedFaces& faces, double crease_angle) {
  const Incidence at = incidence(mesh, faces);
  CreaseSplitter splitter(mesh, faces, crease_angle);
  SmoothGroups result;
  result.corner_vertex.assign(mesh.corner_vertex.size(), kNoVertex);
  result.begin.assign(1, 0);
  result.begin.reserve(mesh.vertex_count() + 1);
  result.corner.reserve(mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const std::span<const std::uint32_t> corners(at.list.data() + at.begin[v], at.begin[v + 1] - at.begin[v]);
    const auto& groups = splitter.groups(corners);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (groups[i] != i) continue;
      result.corner_vertex[corners[i]] = static_cast<std::uint32_t>(result.corner.size());
      result.corner.push_back(corners[i]);
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      result.corner_vertex[corners[i]] = result.corner_vertex[corners[groups[i]]];
    }
    result.begin.push_back(static_cast<std::uint32_t>(result.corner.size()));
  }
  return result;
}

}  // namespace knead::render
