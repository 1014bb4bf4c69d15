#include "knead/remesh/improve.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "knead/remesh/improver.h"

namespace knead::remesh_detail {

namespace {

double tangent_of(double degrees) { return std::tan(degrees * std::numbers::pi / 180); }

// Below which smallest angle triangles are worked at: by flips; by moving vertices; by collapses of edges that are
// longer than min_edge; and with more tolerance.
const double kFlipBelow = tangent_of(35);
const double kMoveBelow = tangent_of(28);
const double kPoor = tangent_of(15);
const double kBad = tangent_of(10);
const double kWorst = tangent_of(7);
const double kHopeless = tangent_of(6);
constexpr double kWide = 0.06;
constexpr double kTight = 0.1;  // of max_chord, for collapses that no triangle needs
constexpr int kMendRounds = 6;  // of work at the worst triangles, on each level

double cosine_of(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }

Bounds bounds_of(double distance, double turn_deg, double fold_deg, double steady_deg) {
  return {distance, {cosine_of(turn_deg), tangent_of(steady_deg)}, distance / 6, cosine_of(fold_deg)};
}

double edge_quality(const Surface& s, std::uint32_t h) {
  const double q = quality(s, h / 3, s.after);
  const std::uint32_t o = s.opposite[h];
  return o == kNone ? q : std::min(q, quality(s, o / 3, s.after));
}

void flip_round(Improver& improver, const Bounds& bounds) {
  Surface& s = improver.surface();
  for (std::uint32_t e = 0; e < s.halfedge.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (h != kNone && edge_quality(s, h) <= kFlipBelow) improver.flip_edge(h, bounds);
  }
}

void collapse_short_edges(Improver& improver, double shortest, const Bounds& bounds) {
  Surface& s = improver.surface();
  std::vector<std::pair<double, std::uint32_t>> shortest_first;
  for (std::uint32_t e = 0; e < s.halfedge.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (h == kNone) continue;
    const double length2 = norm2(s.after[s.target(h)] - s.after[s.origin(h)]);
    if (length2 < shortest * shortest) shortest_first.emplace_back(length2, e);
  }
  std::sort(shortest_first.begin(), shortest_first.end());
  for (const auto& [length, e] : shortest_first) {
    const std::uint32_t h = s.halfedge[e];
    if (h == kNone || norm2(s.after[s.target(h)] - s.after[s.origin(h)]) >= shortest * shortest) continue;
    improver.collapse_edge(h, std::min(kMoveBelow, edge_quality(s, h)), bounds);
  }
}

void move_round(Improver& improver, const Bounds& bounds) {
  Surface& s = improver.surface();
  std::vector<bool> poor(s.vertex_count(), false);
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f) || quality(s, f, s.after) > kMoveBelow) continue;
    for (const std::uint32_t v : s.triangle(f)) poor[v] = true;
  }
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (poor[v]) improver.move_vertex(v, bounds);
  }
}

// The edges of a face, shortest first.
std::array<std::uint32_t, 3> edges_by_length(const Surface& s, std::uint32_t f) {
  std::array<std::uint32_t, 3> edges{3 * f, 3 * f + 1, 3 * f + 2};
  const auto length2 = [&](std::uint32_t h) { return norm2(s.after[s.target(h)] - s.after[s.origin(h)]); };
  std::sort(edges.begin(), edges.end(), [&](std::uint32_t a, std::uint32_t b) { return length2(a) < length2(b); });
  return edges;
}

double longest_length(const Surface& s, std::uint32_t f) {
  const std::uint32_t h = longest_edge(s, f, s.after);
  return norm(s.after[s.target(h)] - s.after[s.origin(h)]);
}

// Whatever helps one triangle: its longest edge flipped, an edge collapsed, a vertex moved.
bool mend_face(Improver& improver, std::uint32_t f, const Bounds& bounds) {
  Surface& s = improver.surface();
  const double was = quality(s, f, s.after);
  const std::array<std::uint32_t, 3> edges = edges_by_length(s, f);
  if (improver.flip_edge(edges[2], bounds)) return true;
  for (const std::uint32_t h : edges) {
    // Where others around are worse, two faces fewer are a gain.
    const double around = std::min(star_quality(s, s.origin(h), s.after[s.origin(h)], {}),
                                   star_quality(s, s.target(h), s.after[s.target(h)], {}));
    if (improver.collapse_edge(h, std::min(std::max(1.5 * was, 1e-3), around), bounds)) return true;
  }
  for (const std::uint32_t v : s.triangle(f)) {
    if (improver.move_vertex(v, bounds) || improver.search_vertex(v, bounds)) return true;
  }
  return improver.absorb_apex(edges[2], bounds);
}

// `wide` is a share of a triangle's longest edge that distances may reach at least.
bool mend_round(Improver& improver, double below, const Bounds& bounds, double wide) {
  Surface& s = improver.surface();
  std::vector<std::pair<double, std::uint32_t>> worst_first;
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f)) continue;
    const double q = quality(s, f, s.after);
    if (q < below) worst_first.emplace_back(q, f);
  }
  std::sort(worst_first.begin(), worst_first.end());
  bool changed = false;
  for (const auto& [q, f] : worst_first) {
    if (!s.is_alive(f) || quality(s, f, s.after) >= below) continue;
    Bounds own = bounds;
    own.distance = std::max(own.distance, wide * longest_length(s, f));
    if (wide > 0) own.crease *= 1.5;
    const bool is_mended =
        mend_face(improver, f, own) || (wide > 0 && improver.split_chord(longest_edge(s, f, s.after)));
    changed = is_mended || changed;
  }
  return changed;
}

Bounds widest_bounds(double chord) {
  Bounds bounds = bounds_of(2 * chord, 80, 80, 20);
  bounds.crease = chord / 3;
  return bounds;
}

}  // namespace

ImprovementCounts untangle(Surface& surface, const Improvement& improvement, std::span<const std::uint32_t> faces) {
  Improver improver(surface, improvement);
  const Bounds bounds = widest_bounds(improvement.targets.max_chord);
  for (const std::uint32_t f : faces) {
    if (!surface.is_alive(f)) continue;
    const std::array<std::uint32_t, 3> edges = edges_by_length(surface, f);
    if (improver.collapse_edge(edges[0], kBad, bounds) || improver.collapse_edge(edges[1], kBad, bounds)) continue;
    if (improver.flip_edge(edges[2], bounds) || improver.flip_edge(edges[1], bounds)) continue;
    for (const std::uint32_t v : surface.triangle(f)) improver.move_vertex(v, bounds);
  }
  improver.settle();
  return improver.counts();
}

ImprovementCounts improve(Surface& surface, const Improvement& improvement) {
  Improver improver(surface, improvement);
  const double chord = improvement.targets.max_chord;
  const Bounds usual = bounds_of(0.5 * chord, 30, 40, 3);
  const Bounds tight = bounds_of(kTight * chord, 30, 40, 3);
  for (int i = 0; i < improvement.targets.iterations; ++i) {
    flip_round(improver, usual);
    if (i % 2 == 0) collapse_short_edges(improver, improvement.targets.min_edge, tight);
    move_round(improver, usual);
  }
  improver.settle();
  return improver.counts();
}

ImprovementCounts mend(Surface& surface, const Improvement& improvement, int level) {
  const double chord = improvement.targets.max_chord;
  struct Level {
    double below = 0;  // quality
    Bounds bounds;
    double wide = 0;
    bool soft_creases = false;
  };
  // What is bad may cost more: such triangles are few, and small.
  const std::array<Level, kCarefulLevels> levels{{{kPoor, bounds_of(0.5 * chord, 30, 40, 3), 0, false},
                                                  {kBad, bounds_of(chord, 50, 60, 10), 0, false},
                                                  {kBad, widest_bounds(chord), 0, false},
                                                  {kWorst, widest_bounds(chord), kWide, false},
                                                  {kHopeless, widest_bounds(chord), kWide, true},
                                                  {kWorst, bounds_of(0.7 * chord, 80, 80, 20), 0, false},
                                                  {kWorst, bounds_of(0.25 * chord, 80, 80, 20), 0, false},
                                                  {kWorst, bounds_of(0.08 * chord, 80, 80, 20), 0, false},
                                                  {kWorst, bounds_of(0.02 * chord, 80, 80, 20), 0, false}}};
  const Level& at = levels.at(static_cast<std::size_t>(level));
  Improver improver(surface, improvement, at.soft_creases);
  const int rounds = at.wide > 0 ? 2 * kMendRounds : kMendRounds;
  for (int i = 0; i < rounds && mend_round(improver, at.below, at.bounds, at.wide); ++i) continue;
  improver.settle();
  return improver.counts();
}

}  // namespace knead::remesh_detail
