#include "knead/remesh/crossings.h"

#include <algorithm>

#include "knead/math/box.h"
#include "knead/mesh/self_intersections.h"

namespace knead::remesh_detail {

namespace {

Vec3d as_float(const Vec3d& p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }

bool overlap(const Box& a, const Box& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.min[axis] > b.max[axis] || b.min[axis] > a.max[axis]) return false;
  }
  return true;
}

// Returns the box of the vertices that may change, widened by 5% of its diagonal.
Box search_box(const Surface& s) {
  std::vector<Vec3d> points;
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (s.has(v, kRegion) && !s.has(v, kRemoved)) points.push_back(s.after[v]);
  }
  Box box = bounding_box(points);
  const double margin = 0.05 * box.diagonal();
  box.min -= Vec3d{margin, margin, margin};
  box.max += Vec3d{margin, margin, margin};
  return box;
}

}  // namespace

CrossingSearch::CrossingSearch(const Mesh& before, const Patch& patch, bool single_precision, int threads,
                               const Progress* progress)
    : single_precision_(single_precision), threads_(threads), progress_(progress) {
  const Box box = search_box(patch.surface);
  std::vector<std::uint32_t> number(before.vertex_count(), kNone);
  for (std::uint32_t p = 0; p < patch.vertex_source.size(); ++p) number[patch.vertex_source[p]] = p;
  const auto first = static_cast<std::uint32_t>(patch.vertex_source.size());
  std::vector<Triangle> parts;
  for (std::size_t f = 0; f < before.face_count(); ++f) {
    stop_if_cancelled(progress_);
    if (patch.holds_face[f] || before.face(f).size() < 3) continue;
    parts.clear();
    triangulate_polygon(before.positions, before.face(f), parts);
    for (const Triangle& t : parts) {
      const std::array<Vec3d, 3> corners{before.positions[t[0]], before.positions[t[1]], before.positions[t[2]]};
      if (!overlap(bounding_box(corners), box)) continue;
      Triangle named{};
      for (std::size_t i = 0; i < 3; ++i) {
        if (number[t[i]] == kNone) {
          number[t[i]] = first + static_cast<std::uint32_t>(outside_positions_.size());
          outside_positions_.push_back(corners[i]);
        }
        named[i] = number[t[i]];
      }
      outside_.push_back(named);
    }
  }
}

Crossings CrossingSearch::find(const Patch& patch) const {
  const Surface& s = patch.surface;
  // Order: the original vertices of the patch, the vertices outside, then the vertices that splits have made.
  const auto first = static_cast<std::uint32_t>(patch.vertex_source.size());
  const auto shift = static_cast<std::uint32_t>(outside_positions_.size());
  std::vector<Vec3d> positions(s.after.begin(), s.after.begin() + first);
  positions.insert(positions.end(), outside_positions_.begin(), outside_positions_.end());
  positions.insert(positions.end(), s.after.begin() + first, s.after.end());
  if (single_precision_) std::transform(positions.begin(), positions.end(), positions.begin(), as_float);
  std::vector<Triangle> triangles = outside_;
  std::vector<std::uint32_t> faces;
  std::vector<bool> is_changed(triangles.size(), false);
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f)) continue;
    Triangle t = s.triangle(f);
    bool changed = !patch.is_unchanged(f);
    for (std::uint32_t& v : t) {
      changed = changed || s.has(v, kMoved) || s.has(v, kRegion);
      if (v >= first) v += shift;
    }
    triangles.push_back(t);
    faces.push_back(f);
    is_changed.push_back(changed);
  }
  SelfIntersectionOptions options;
  options.threads = threads_;
  options.progress = progress_;
  stop_if_cancelled(progress_);
  const SelfIntersections found = self_intersections(triangles, positions, options);
  Crossings crossings;
  if (!found.complete) crossings.pairs = found.count;
  for (const auto& [t, u] : found.pairs) {
    if (!is_changed[t] && !is_changed[u]) continue;
    ++crossings.pairs;
    for (const std::uint32_t w : {t, u}) {
      if (w >= outside_.size()) crossings.faces.push_back(faces[w - outside_.size()]);
    }
  }
  std::sort(crossings.faces.begin(), crossings.faces.end());
  crossings.faces.erase(std::unique(crossings.faces.begin(), crossings.faces.end()), crossings.faces.end());
  return crossings;
}

}  // namespace knead::remesh_detail
