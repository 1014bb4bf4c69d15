// Improves the triangles of a surface after a deformation and keeps the volume: compensation, rounds of flips,
// collapses and moves, and repairs of the worst triangles.
#include "remesh/improve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "math/elementary.h"
#include "remesh/facets.h"
#include "remesh/improver.h"

namespace knead::detail {

namespace {

constexpr double kMaxOffset = 1.5;            // of a vertex, relative to the largest deviation around it
constexpr double kMaxScaleDifference = 0.25;  // of the common factor from 1
constexpr int kMaxScaleRounds = 4;

// Returns a flag for each vertex: true if it may move.
std::vector<bool> find_open(const Surface& s, const std::vector<bool>& locked) {
  std::vector<bool> open(s.vertex_count());
  for (std::uint32_t v = 0; v < open.size(); ++v) {
    open[v] = s.has(v, kMoved) && !s.has(v, kImmovable) && !(v < locked.size() && locked[v]);
  }
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if (!s.edge_has(h, kFeature)) continue;
    open[s.origin(h)] = false;
    open[s.target(h)] = false;
  }
  return open;
}

// Returns the displacement of each vertex.
std::vector<Vec3d> offsets(const Surface& s, const std::vector<Vec3d>& deviations, const std::vector<bool>& open) {
  std::vector<Vec3d> star(s.vertex_count());
  std::vector<double> share(s.vertex_count(), 0.0);    // six times the volume
  std::vector<double> largest(s.vertex_count(), 0.0);  // deviation
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    const Vec3d n = area_vector(s, f, s.after);
    for (const std::uint32_t v : s.triangle(f)) star[v] += n;
    for (std::uint32_t h = static_cast<std::uint32_t>(3 * f); h < 3 * f + 3; ++h) {
      const Vec3d& d = deviations[s.edge[h]];
      const std::uint32_t a = s.origin(h);
      const std::uint32_t b = s.target(h);
      const double both = (open[a] ? 1 : 0) + (open[b] ? 1 : 0);
      for (const std::uint32_t v : {a, b}) {
        if (!open[v]) continue;
        share[v] += dot(n, d) / both;
        largest[v] = std::max(largest[v], norm(d));
      }
    }
  }
  std::vector<Vec3d> result(s.vertex_count());
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    const double size = norm(star[v]);
    if (!open[v] || !(size > 0)) continue;
    const double limit = kMaxOffset * largest[v];
    result[v] = star[v] * (std::clamp(share[v] / size, -limit, limit) / size);
  }
  return result;
}

double tangent_of(double degrees) { return elementary::tan(degrees * std::numbers::pi / 180); }

// A triangle is changed only if its quality, the tangent of its smallest angle, is below one of these thresholds.
//
// The result should have no angle below 5 degrees: tests/surveys/remesh_survey.cpp requires this, and 97% of its random
// sessions reach it (docs/mathematics.md, "Random sessions"). So the thresholds of repair_triangles() end at 7 degrees,
// a little above; those of earlier levels are higher, because a change within narrow bounds costs little. No vertex
// moves for a triangle above 28 degrees, so details that a stroke did not stretch are not smoothed.
const double kFlipBelow = tangent_of(35);    // improve(): try to flip an edge
const double kMoveBelow = tangent_of(28);    // improve(): try to move the vertices
const double kRepairBelow = tangent_of(15);  // repair_triangles(), level 0: any change, within the bounds of improve()
const double kWiderRepairBelow = tangent_of(10);  // levels 1 and 2: within wider bounds
const double kWidestRepairBelow =
    tangent_of(7);                           // level 3: distances up to kEdgeShare of the longest edge; also split it
const double kMinRepaired = tangent_of(10);  // repair_crossings(): least quality around a collapsed edge
constexpr double kEdgeShare = 0.06;          // of the longest edge of a triangle
constexpr double kShortEdgeShare = 0.1;    // of max_chord: bound for collapses of short edges, which no triangle needs
constexpr int kRepairRounds = 6;           // rounds over the worst triangles, on each level
constexpr std::size_t kMaxFaceGrowth = 8;  // factor by which splits in planes may increase the number of faces
constexpr std::size_t kFewFaces = 1000;    // added before that factor

double cosine_of(double degrees) { return elementary::cos(degrees * std::numbers::pi / 180); }

Bounds bounds_of(double distance, double turn_deg, double fold_deg, double reliable_deg) {
  return {distance, {cosine_of(turn_deg), tangent_of(reliable_deg)}, distance / 6, cosine_of(fold_deg)};
}

double edge_quality(Improver& improver, std::uint32_t h) {
  const double q = improver.quality_of(h / 3);
  const std::uint32_t o = improver.surface().opposite[h];
  return o == kNone ? q : std::min(q, improver.quality_of(o / 3));
}

// Lets the edge rest if a flip of it is no improvement. Returns true if it rests.
bool lay_to_rest(Improver& improver, SurfaceMemory& memory, std::uint32_t e) {
  if (memory.edge_rests(e)) return true;
  const std::uint32_t h = improver.surface().halfedge[e];
  const auto is_poor = [&](std::uint32_t side) { return side != kNone && improver.is_poor(side / 3, kFlipBelow); };
  const bool may_gain = h != kNone && (is_poor(h) || is_poor(improver.surface().opposite[h]));
  if (may_gain && improver.gains_by_flip(h)) return false;
  memory.let_edge_rest(e);
  return true;
}

void flip_round(Improver& improver, const Improvement& improvement, Blocks& blocks, const Bounds& bounds) {
  constexpr std::size_t grain = 4096;
  const Surface& s = improver.surface();
  SurfaceMemory& memory = *improvement.memory;
  memory.measure(s, improvement.threads);
  blocks.find_inner(s);
  std::vector<std::uint32_t> block(s.halfedge.size());
  parallel_for(block.size(), grain, improvement.threads, [&](std::size_t begin, std::size_t end) {
    improver.stop_if_cancelled();
    for (std::size_t e = begin; e < end; ++e) {
      lay_to_rest(improver, memory, static_cast<std::uint32_t>(e));
      block[e] = blocks.around_edge(s, static_cast<std::uint32_t>(e));
    }
  });
  blocks.change_all(improver, improvement, block, [&](Improver& by, std::uint32_t e) {
    if (!lay_to_rest(by, memory, e)) by.try_flip(s.halfedge[e], bounds);
  });
}

using ByLength = std::vector<std::pair<double, std::uint32_t>>;  // the square of a length, and its edge

ByLength find_short_edges(const Surface& s, double shortest, int threads) {
  constexpr std::size_t grain = 4096;
  std::vector<ByLength> of_chunk(s.halfedge.size() / grain + 1);
  parallel_for(s.halfedge.size(), grain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const std::uint32_t h = s.halfedge[e];
      if (h == kNone) continue;
      const double length2 = norm2(s.after[s.target(h)] - s.after[s.origin(h)]);
      if (length2 < shortest * shortest) of_chunk[begin / grain].emplace_back(length2, e);
    }
  });
  ByLength found;
  for (const ByLength& some : of_chunk) found.insert(found.end(), some.begin(), some.end());
  std::sort(found.begin(), found.end());
  return found;
}

void collapse_short_edges(Improver& improver, double shortest, int threads, const Bounds& bounds) {
  const Surface& s = improver.surface();
  const ByLength shortest_first = find_short_edges(s, shortest, threads);
  for (const auto& [length, e] : shortest_first) {
    if (improver.must_end()) break;
    const std::uint32_t h = s.halfedge[e];
    if (h == kNone || norm2(s.after[s.target(h)] - s.after[s.origin(h)]) >= shortest * shortest) continue;
    improver.collapse_edge(
        h, [&] { return std::min(kMoveBelow, edge_quality(improver, h)); }, bounds);
  }
}

void move_round(Improver& improver, const Improvement& improvement, Blocks& blocks, const Bounds& bounds) {
  const Surface& s = improver.surface();
  SurfaceMemory& memory = *improvement.memory;
  memory.measure(s, improvement.threads);
  std::vector<std::uint8_t> poor(s.vertex_count(), 0);
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f) || !improver.is_poor(f, kMoveBelow)) continue;
    for (const std::uint32_t v : s.triangle(f)) poor[v] = 1;
  }
  blocks.find_inner(s);
  std::vector<std::uint32_t> block(s.vertex_count(), kNone);
  for (std::uint32_t v = 0; v < block.size(); ++v) {
    if (poor[v] != 0) block[v] = blocks.around(v);
  }
  blocks.change_all(improver, improvement, block, [&](Improver& by, std::uint32_t v) {
    if (memory.vertex_rests(v)) return;
    if (by.move_vertex(v, bounds) == Attempt::impossible) memory.let_vertex_rest(v);
  });
}

// Returns the edges of a face, shortest first.
std::array<std::uint32_t, 3> edges_by_length(const Surface& s, std::uint32_t f) {
  std::array<std::uint32_t, 3> edges{3 * f, 3 * f + 1, 3 * f + 2};
  const auto length2 = [&](std::uint32_t h) { return norm2(s.after[s.target(h)] - s.after[s.origin(h)]); };
  std::sort(edges.begin(), edges.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(length2(a), a) < std::pair(length2(b), b);  // a whole order: the same in every standard library
  });
  return edges;
}

double longest_length(const Surface& s, std::uint32_t f) {
  const std::uint32_t h = longest_edge(s, f, s.after);
  return norm(s.after[s.target(h)] - s.after[s.origin(h)]);
}

// Tries to flip the longest edge, to collapse an edge, then to move a vertex. Returns true after the first change that
// succeeds.
bool repair_face(Improver& improver, std::uint32_t f, const Bounds& bounds) {
  Surface& s = improver.surface();
  const double was = improver.quality_of(f);
  for (const std::uint32_t v : s.triangle(f)) {
    if (is_crowded(s, v)) return false;
  }
  const std::array<std::uint32_t, 3> edges = edges_by_length(s, f);
  if (improver.flip_edge(edges[2], bounds)) return true;
  std::array<std::optional<double>, 3> stars{};  // of the origins of half-edges 3 f to 3 f + 2
  const auto star_of = [&](std::size_t i) {
    const std::uint32_t v = s.corner[3 * static_cast<std::size_t>(f) + i];
    if (!stars[i]) stars[i] = star_quality(s, v, s.after[v], {});
    return *stars[i];
  };
  for (const std::uint32_t h : edges) {
    // If other triangles around are worse, removing two faces is an improvement.
    const auto least = [&] { return std::min({std::max(1.5 * was, 1e-3), star_of(h % 3), star_of((h + 1) % 3)}); };
    if (improver.collapse_edge(h, least, bounds)) return true;
  }
  for (const std::uint32_t v : s.triangle(f)) {
    if (improver.move_vertex(v, bounds) == Attempt::done || improver.search_vertex(v, bounds)) return true;
  }
  return improver.merge_apex_into_crease(edges[2], bounds);
}

using PoorFaces = std::vector<std::pair<double, std::uint32_t>>;  // quality and face, worst first

PoorFaces find_poor_faces(Improver& improver, double below, bool of_parts = false) {
  const Surface& s = improver.surface();
  PoorFaces poor;
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f) || (of_parts && !s.is_of_part(f))) continue;
    if (improver.is_poor(f, below)) poor.emplace_back(improver.quality_of(f), f);
  }
  std::sort(poor.begin(), poor.end());
  return poor;
}

// One level of repair_triangles().
struct RepairLevel {
  double below = 0;  // repairs the faces of less quality
  Bounds bounds;
  double edge_share = 0;         // outside parts, the allowed distance is at least this share of a face's longest edge
  double max_part_distance = 0;  // in a flat face of a part
};

// Repairs the poor faces; splits those that no other change improves, if that is allowed. Returns true if a face was
// changed. What a guard refuses depends on other faces, too, so with one every face is tried again.
bool repair_round(Improver& improver, const Improvement& task, const PoorFaces& poor, const RepairLevel& level,
                  bool may_split) {
  Surface& s = improver.surface();
  SurfaceMemory& memory = *task.memory;
  memory.begin_repairs(may_split);
  bool changed = false;
  for (const auto& [q, f] : poor) {
    if (improver.must_end()) break;
    if (!s.is_alive(f) || !improver.is_poor(f, level.below)) continue;
    if (task.guard == nullptr && memory.is_refused(s, f)) continue;
    Bounds own = level.bounds;
    own.distance = s.is_of_part(f) ? std::min(own.distance, level.max_part_distance)
                                   : std::max(own.distance, level.edge_share * longest_length(s, f));
    if (may_split) own.crease *= 1.5;
    const bool is_repaired =
        repair_face(improver, f, own) || (may_split && improver.split_chord(longest_edge(s, f, s.after)));
    if (!is_repaired) memory.refuse(f);
    changed = is_repaired || changed;
  }
  return changed;
}

Improvement with_memory(Improvement improvement, SurfaceMemory& own) {
  if (improvement.memory == nullptr) improvement.memory = &own;
  return improvement;
}

// Returns max_chord, or the tolerance of planes that replaces it in an exact improvement.
double chord_of(const Surface& s, const Improvement& improvement) {
  return improvement.exact ? plane_tolerance(s.before) : improvement.targets.max_chord;
}

Bounds widest_bounds(double chord) {
  Bounds bounds = bounds_of(2 * chord, 80, 80, 20);
  bounds.crease = chord / 3;
  return bounds;
}

}  // namespace

MissingVolume estimate_missing_volume(const Surface& s, const std::vector<Vec3d>& deviations) {
  MissingVolume missing;
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    const double term = dot(area_vector(s, h / 3, s.after), deviations[s.edge[h]]);
    missing.sum += term;
    missing.sum_of_sizes += std::abs(term);
  }
  return {missing.sum / 6, missing.sum_of_sizes / 6};
}

double enclosed_volume(const Surface& s, const std::vector<Vec3d>& positions) {
  Vec3d center{};
  for (const Vec3d& p : s.before) center += p;
  if (!s.before.empty()) center = center / static_cast<double>(s.before.size());
  double sum = 0;
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f)) continue;
    const auto [a, b, c] = s.triangle(f);
    sum += dot(positions[a] - center, cross(positions[b] - center, positions[c] - center));
  }
  return sum / 6;
}

double compensate(Surface& s, const std::vector<Vec3d>& deviations, const std::vector<bool>& locked, double missing) {
  const std::vector<Vec3d> d = offsets(s, deviations, find_open(s, locked));
  const std::vector<Vec3d> from = s.after;
  const double was = enclosed_volume(s, from);
  double scale = 1;
  double grown = 0;
  for (int round = 0; round < kMaxScaleRounds; ++round) {
    for (std::size_t v = 0; v < from.size(); ++v) s.after[v] = from[v] + d[v] * scale;
    grown = enclosed_volume(s, s.after) - was;
    const double next =
        grown != 0 ? std::clamp(scale * missing / grown, 1 - kMaxScaleDifference, 1 + kMaxScaleDifference) : 1;
    if (std::abs(next - scale) < 1e-9) break;
    if (round + 1 < kMaxScaleRounds) scale = next;
  }
  return grown;
}

ImprovementCounts& ImprovementCounts::operator+=(const ImprovementCounts& more) {
  splits += more.splits;
  flips += more.flips;
  collapses += more.collapses;
  volume += more.volume;
  return *this;
}

void spread_volume(Surface& s, double volume, double max_distance, const std::vector<bool>& locked) {
  if (volume == 0) return;
  const Improver improver(s, {});
  std::vector<std::pair<std::uint32_t, Vec3d>> free;  // with the sum of the area vectors around it
  double area = 0;
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if ((v < locked.size() && locked[v]) || !s.has(v, kMoved) || improver.freedom(v) != Freedom::free) continue;
    free.emplace_back(v, star_vector(s, v));
    area += norm(free.back().second);
  }
  const double distance = std::clamp(6 * volume / area, -max_distance, max_distance);
  for (const auto& [v, star] : free) {
    if (norm2(star) > 0) s.after[v] += star * (distance / norm(star));
  }
}

ImprovementCounts repair_crossings(Surface& surface, const Improvement& improvement,
                                   std::span<const std::uint32_t> faces) {
  Improver improver(surface, improvement);
  const Bounds bounds = widest_bounds(chord_of(surface, improvement));
  for (const std::uint32_t f : faces) {
    if (improver.must_end()) break;
    if (!surface.is_alive(f)) continue;
    const std::array<std::uint32_t, 3> edges = edges_by_length(surface, f);
    const auto least = [] { return kMinRepaired; };
    if (improver.collapse_edge(edges[0], least, bounds)) continue;
    if (improver.collapse_edge(edges[1], least, bounds)) continue;
    if (improver.flip_edge(edges[2], bounds) || improver.flip_edge(edges[1], bounds)) continue;
    for (const std::uint32_t v : surface.triangle(f)) improver.move_vertex(v, bounds);
  }
  return improver.counts();
}

ImprovementCounts improve(Surface& surface, const Improvement& improvement) {
  SurfaceMemory own;
  const Improvement task = with_memory(improvement, own);
  SurfaceMemory& memory = *task.memory;
  memory.begin(surface, task.threads);
  Improver improver(surface, task);
  Blocks blocks(surface, task.threads);
  const double chord = chord_of(surface, improvement);
  const Bounds bounds = bounds_of(0.5 * chord, 30, 40, 3);
  const Bounds collapse_bounds = bounds_of(kShortEdgeShare * chord, 30, 40, 3);
  for (int i = 0; i < improvement.targets.iterations && !improver.must_end(); ++i) {
    flip_round(improver, task, blocks, bounds);
    if (i % 2 == 0) collapse_short_edges(improver, improvement.targets.min_edge, task.threads, collapse_bounds);
    move_round(improver, task, blocks, bounds);
  }
  return improver.counts();
}

ImprovementCounts improve_flat_faces(Surface& surface, const Improvement& improvement) {
  SurfaceMemory own;
  Improvement task = with_memory(improvement, own);
  task.exact = true;
  task.may_collapse = false;
  task.memory->begin(surface, task.threads);
  const double chord = chord_of(surface, task);
  const RepairLevel level{kRepairBelow, widest_bounds(chord), 0, 2 * chord};
  const std::size_t max_faces = kMaxFaceGrowth * (surface.face_count() + kFewFaces);
  Improver improver(surface, task);
  for (int i = 0; i < 2 * kRepairRounds && surface.face_count() < max_faces && !improver.must_end(); ++i) {
    if (!repair_round(improver, task, find_poor_faces(improver, level.below, true), level, true)) break;
  }
  return improver.counts();
}

ImprovementCounts repair_triangles(Surface& surface, const Improvement& improvement, int level) {
  const bool may_split = level + 1 == kRepairLevels;
  if (improvement.exact && may_split) return improve_flat_faces(surface, improvement);
  SurfaceMemory own;
  const Improvement task = with_memory(improvement, own);
  task.memory->begin(surface, task.threads);
  const double chord = chord_of(surface, improvement);
  // Worse triangles justify larger changes: they are few and small.
  const std::array<RepairLevel, kGuardedLevels> levels{
      {{kRepairBelow, bounds_of(0.5 * chord, 30, 40, 3), 0, 0.5 * chord},
       {kWiderRepairBelow, bounds_of(chord, 50, 60, 10), 0, 0.5 * chord},
       {kWiderRepairBelow, widest_bounds(chord), 0, 0.5 * chord},
       {kWidestRepairBelow, widest_bounds(chord), kEdgeShare, 0.5 * chord},
       {kWidestRepairBelow, bounds_of(0.7 * chord, 80, 80, 20), 0, 0.5 * chord},
       {kWidestRepairBelow, bounds_of(0.25 * chord, 80, 80, 20), 0, chord},
       {kWidestRepairBelow, bounds_of(0.08 * chord, 80, 80, 20), 0, chord},
       {kWidestRepairBelow, bounds_of(0.02 * chord, 80, 80, 20), 0, chord}}};
  const RepairLevel& at = levels.at(static_cast<std::size_t>(level));
  Improver improver(surface, task);
  const int rounds = may_split ? 2 * kRepairRounds : kRepairRounds;
  PoorFaces poor = find_poor_faces(improver, at.below);
  // Splitting helps a few faces between better ones. Many poor faces come from edges that must not be split; splits
  // would then go on without end.
  const std::size_t few = std::min(2 * poor.size(), surface.face_count() / 4);
  for (int i = 0; i < rounds && !improver.must_end(); ++i) {
    if (!repair_round(improver, task, poor, at, may_split && poor.size() <= few)) break;
    poor = find_poor_faces(improver, at.below);
  }
  return improver.counts();
}

}  // namespace knead::detail
