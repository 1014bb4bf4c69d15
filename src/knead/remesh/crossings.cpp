#include "knead/remesh/crossings.h"

#include <algorithm>
#include <cmath>

#include "knead/math/box.h"
#include "knead/mesh/self_intersections.h"

namespace knead::remesh_detail {

namespace {

Vec3d as_float(const Vec3d& p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }

// Coordinates too small for the predicates count as 0.
Vec3d without_tiny(const Vec3d& p) {
  const auto kept = [](double x) { return std::abs(x) < 0x1p-250 ? 0.0 : x; };
  return {kept(p.x), kept(p.y), kept(p.z)};
}

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
    : first_(static_cast<std::uint32_t>(patch.vertex_source.size())),
      single_precision_(single_precision),
      threads_(threads),
      progress_(progress) {
  const Box box = search_box(patch.surface);
  std::vector<std::uint32_t> number(before.vertex_count(), kNone);
  for (std::uint32_t p = 0; p < patch.vertex_source.size(); ++p) number[patch.vertex_source[p]] = p;
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
          number[t[i]] = first_ + static_cast<std::uint32_t>(outside_positions_.size());
          outside_positions_.push_back(corners[i]);
        }
        named[i] = number[t[i]];
      }
      outside_.push_back(named);
    }
  }
}

Vec3d CrossingSearch::as_written(const Vec3d& p) const { return without_tiny(single_precision_ ? as_float(p) : p); }

PlacedFace CrossingSearch::as_written(PlacedFace face) const {
  for (std::uint32_t& v : face.vertices) v = number(v);
  for (Vec3d& corner : face.corners) corner = as_written(corner);
  return face;
}

CrossingSearch::Triangles CrossingSearch::triangles(const Surface& s) const {
  Triangles result;
  result.positions.reserve(s.vertex_count() + outside_positions_.size());
  const auto first = s.after.begin() + first_;
  result.positions.assign(s.after.begin(), first);
  result.positions.insert(result.positions.end(), outside_positions_.begin(), outside_positions_.end());
  result.positions.insert(result.positions.end(), first, s.after.end());
  for (Vec3d& p : result.positions) p = as_written(p);
  result.triangles.reserve(outside_.size() + s.face_count());
  result.triangles = outside_;
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f)) continue;
    const auto [a, b, c] = s.triangle(f);
    result.triangles.push_back({number(a), number(b), number(c)});
    result.faces.push_back(f);
  }
  return result;
}

Crossings CrossingSearch::find(const Patch& patch) const {
  const Surface& s = patch.surface;
  const Triangles searched = triangles(s);
  std::vector<bool> is_changed(searched.triangles.size(), false);
  for (std::size_t i = 0; i < searched.faces.size(); ++i) {
    const std::uint32_t f = searched.faces[i];
    const Triangle t = s.triangle(f);
    is_changed[outside_.size() + i] = !patch.is_unchanged(f) || std::any_of(t.begin(), t.end(), [&](std::uint32_t v) {
      return s.has(v, kMoved) || s.has(v, kRegion);
    });
  }
  SelfIntersectionOptions options;
  options.threads = threads_;
  options.progress = progress_;
  options.chosen = &is_changed;
  stop_if_cancelled(progress_);
  const SelfIntersections found = self_intersections(searched.triangles, searched.positions, options);
  Crossings crossings;
  if (!found.complete) crossings.pairs = found.count;
  std::vector<bool> crosses(found.pairs.empty() ? 0 : searched.triangles.size(), false);
  for (const auto& [t, u] : found.pairs) {
    ++crossings.pairs;
    crosses[t] = true;
    crosses[u] = true;
  }
  for (std::size_t w = outside_.size(); w < crosses.size(); ++w) {  // in ascending order
    if (crosses[w]) crossings.faces.push_back(searched.faces[w - outside_.size()]);
  }
  return crossings;
}

}  // namespace knead::remesh_detail
