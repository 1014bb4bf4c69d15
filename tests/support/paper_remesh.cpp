#include "support/paper_remesh.h"

#include <algorithm>

#include "knead/mesh.h"
#include "remesh/improver.h"
#include "remesh/patch.h"

namespace knead::test {

namespace {

using namespace detail;

SurfaceTree tree_of(const Surface& s) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    if (s.is_alive(f)) triangles.push_back(s.triangle(f));
  }
  return {triangles, s.after};
}

// Every vertex that is free towards the mean of its neighbours, across its normal, and back onto the surface.
void diffuse(Surface& s, const Improver& improver) {
  const SurfaceTree undiffused = tree_of(s);
  std::vector<Vec3d> moved = s.after;
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (improver.freedom(v) != Freedom::free) continue;
    Vec3d sum{};
    double count = 0;
    s.for_each_outgoing(v, [&](std::uint32_t h) {
      sum += s.after[s.target(h)];
      ++count;
    });
    const Vec3d star = star_vector(s, v);
    if (!(norm2(star) > 0)) continue;
    Vec3d d = sum / count - s.after[v];
    d -= star * (dot(d, star) / norm2(star));
    const auto projected = undiffused.closest(s.after[v] + d * 0.5, norm(d));
    if (projected && star_quality(s, v, projected->point, {0, kMinReliableQuality}) >= 0) moved[v] = projected->point;
  }
  s.after = std::move(moved);
}

// Whether the faces around the edge, but for its own, keep their side with both ends at p.
bool keeps_sides(const Surface& s, std::uint32_t h, const Vec3d& p) {
  bool keeps = true;
  for (const std::uint32_t v : {s.origin(h), s.target(h)}) {
    s.for_each_outgoing(v, [&](std::uint32_t e) {
      if (e / 3 == h / 3 || e / 3 == s.opposite[h] / 3) return;
      const Vec3d is = cross(s.after[s.target(e)] - p, s.after[s.apex(e)] - p);
      keeps = keeps && dot(is, area_vector(s, e / 3, s.after)) > 0;
    });
  }
  return keeps;
}

std::size_t collapse_short_edges(Surface& s, const Improver& improver, const RemeshTargets& targets) {
  std::size_t count = 0;
  for (std::uint32_t e = 0; e < s.halfedge.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (h == kNone || s.opposite[h] == kNone || s.edge_has(h, kFeature)) continue;
    const std::uint32_t a = s.origin(h);
    const std::uint32_t b = s.target(h);
    const Vec3d middle = (s.after[a] + s.after[b]) * 0.5;
    const bool is_free = improver.freedom(a) == Freedom::free && improver.freedom(b) == Freedom::free;
    if (!is_free || norm2(s.after[b] - s.after[a]) >= targets.min_edge * targets.min_edge) continue;
    const double off = std::max(plane_distance(s, a, middle), plane_distance(s, b, middle));
    if (off > 0.5 * targets.max_chord || !keeps_sides(s, h, middle) || !can_collapse(s, h)) continue;
    collapse(s, h, middle, 0.5);
    ++count;
  }
  return count;
}

ImprovementCounts diffuse_and_collapse(Surface& surface, const Improvement& improvement) {
  const Improver improver(surface, improvement);
  ImprovementCounts counts;
  for (int i = 0; i < improvement.targets.iterations; ++i) diffuse(surface, improver);
  counts.collapses = collapse_short_edges(surface, improver, improvement.targets);
  for (int i = 0; i < improvement.targets.iterations; ++i) diffuse(surface, improver);
  return counts;
}

}  // namespace

Remeshed remesh_as_in_the_paper(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                                const RemeshOptions& options) {
  MorePlaces none;
  return remesh_with(before, after, deformation, options, diffuse_and_collapse, none);
}

}  // namespace knead::test
