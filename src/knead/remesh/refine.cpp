#include "knead/remesh/refine.h"

#include <algorithm>
#include <cmath>

#include "knead/math/elementary.h"
#include "knead/remesh/face_samples.h"
#include "knead/remesh/shape.h"

namespace knead::remesh_detail {

namespace {

constexpr int kMostRounds = 60;
constexpr double kFeatureShare = 1.0 / 6;  // of max_chord: the target for features
constexpr double kCapCosine = -0.6;        // of 127 degrees: split the longest edge of such a triangle first
constexpr double kShortestShare = 1e-2;    // of max_chord: half the length below which edges are not split

// Returns for each vertex the sum of the area vectors of its faces.
std::vector<Vec3d> mean_normals(const Surface& s, const std::vector<Vec3d>& positions) {
  std::vector<Vec3d> normals(s.vertex_count());
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    const Vec3d n = area_vector(s, f, positions);
    for (const std::uint32_t v : s.triangle(f)) normals[v] += n;
  }
  return normals;
}

// Returns true if the angle opposite to the half-edge is very obtuse.
bool is_cap(const Surface& s, std::uint32_t h) {
  const Vec3d& apex = s.after[s.apex(h)];
  const Vec3d u = s.after[s.origin(h)] - apex;
  const Vec3d v = s.after[s.target(h)] - apex;
  return dot(u, v) < kCapCosine * norm(u) * norm(v);
}

double angle_between(const Vec3d& a, const Vec3d& b) { return elementary::atan2(norm(cross(a, b)), dot(a, b)); }

}  // namespace

Refinement::Refinement(Surface& surface, const Deformation& deformation, const RemeshOptions& options,
                       std::size_t outside, Deadline& deadline)
    : s_(surface),
      deformation_(deformation),
      targets_(options.targets),
      whole_(options.whole),
      progress_(options.progress),
      deadline_(deadline),
      shortest_(kShortestShare * options.targets.max_chord),
      outside_(static_cast<double>(outside)) {
  deviation_.resize(s_.halfedge.size());
  for (std::uint32_t e = 0; e < s_.halfedge.size(); ++e) {
    if ((s_.edge_flags[e] & kLocked) == 0) uncarried_.push_back(e);
  }
}

bool Refinement::split_rounds() {
  for (int round = 0; round < kMostRounds; ++round) {
    if (deadline_.is_over()) return false;
    const Round done = split_round({});
    if (done != Round::split) return done == Round::met;
  }
  return false;
}

bool Refinement::refine() {
  may_refuse_ = true;
  return split_rounds();
}

bool Refinement::refine_faces(std::span<const std::uint32_t> faces) {
  std::vector<bool> forced(s_.halfedge.size(), false);
  for (const std::uint32_t f : faces) {
    for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
      forced[s_.edge[h]] = true;
      untested_.push_back(s_.edge[h]);
    }
  }
  may_refuse_ = false;
  return split_round(forced) != Round::stopped && split_rounds();
}

double Refinement::length2(std::uint32_t e, const std::vector<Vec3d>& positions) const {
  const std::uint32_t h = s_.halfedge[e];
  return norm2(positions[s_.target(h)] - positions[s_.origin(h)]);
}

// Returns false if that would be too much work.
bool Refinement::carry_middles() {
  if (static_cast<double>(uncarried_.size()) > points_left()) {
    if (may_refuse_) refuse(uncarried_, 0);
    return false;
  }
  std::vector<Vec3d> points(uncarried_.size());
  for (std::size_t i = 0; i < uncarried_.size(); ++i) {
    const std::uint32_t h = s_.halfedge[uncarried_[i]];
    points[i] = (s_.before[s_.origin(h)] + s_.before[s_.target(h)]) * 0.5;
  }
  deformation_.carry(points);
  carried_ += static_cast<double>(points.size());
  for (std::size_t i = 0; i < uncarried_.size(); ++i) {
    const std::uint32_t h = s_.halfedge[uncarried_[i]];
    const Vec3d chord = (s_.after[s_.origin(h)] + s_.after[s_.target(h)]) * 0.5;
    deviation_[uncarried_[i]] = points[i] - chord;
  }
  untested_.insert(untested_.end(), uncarried_.begin(), uncarried_.end());
  uncarried_.clear();
  return true;
}

// Returns true if the edge may be split: it is not locked and not too short.
bool Refinement::is_open(std::uint32_t e) const {
  return (s_.edge_flags[e] & kLocked) == 0 &&
         std::min(length2(e, s_.before), length2(e, s_.after)) > 4 * shortest_ * shortest_;
}

bool Refinement::is_moved(std::uint32_t e) const {
  const std::uint32_t a = s_.origin(s_.halfedge[e]);
  const std::uint32_t b = s_.target(s_.halfedge[e]);
  return deviation_[e] != Vec3d{} || s_.before[a] != s_.after[a] || s_.before[b] != s_.after[b];
}

bool Refinement::needs_split(std::uint32_t e, const std::vector<Vec3d>& normals_before,
                             const std::vector<Vec3d>& normals_after) const {
  const bool is_feature = (s_.edge_flags[e] & kFeature) != 0;
  const double chord = targets_.max_chord * (is_feature ? kFeatureShare : 1.0);
  if (norm2(deviation_[e]) > chord * chord) return true;
  const bool moves = is_moved(e);
  if (!moves && !whole_) return false;
  const double size2 = length2(e, s_.after);
  if (size2 > targets_.max_edge * targets_.max_edge) return true;
  // Splits of boundaries depend on their two ends only: coincident boundaries are then split equally.
  if (!moves || (s_.edge_flags[e] & kBoundary) != 0 || size2 < targets_.min_edge * targets_.min_edge) return false;
  const std::uint32_t a = s_.origin(s_.halfedge[e]);
  const std::uint32_t b = s_.target(s_.halfedge[e]);
  return angle_between(normals_after[a], normals_after[b]) >
         targets_.max_angle + angle_between(normals_before[a], normals_before[b]);
}

std::vector<std::uint32_t> Refinement::find_marked(const std::vector<bool>& forced) {
  std::vector<std::uint32_t> marked;
  if (untested_.empty()) return marked;
  const std::vector<Vec3d> normals_before = mean_normals(s_, s_.before);
  const std::vector<Vec3d> normals_after = mean_normals(s_, s_.after);
  std::sort(untested_.begin(), untested_.end());
  untested_.erase(std::unique(untested_.begin(), untested_.end()), untested_.end());
  for (const std::uint32_t e : untested_) {
    stop_if_cancelled(progress_);
    if (!is_open(e)) continue;
    if ((e < forced.size() && forced[e]) || needs_split(e, normals_before, normals_after)) marked.push_back(e);
  }
  untested_.clear();
  return marked;
}

// Returns the longest edges of faces that are large compared with the deformation and that bend inside; nothing if to
// look at them would be too much work.
std::optional<std::vector<std::uint32_t>> Refinement::find_edges_of_large_faces() const {
  std::vector<std::uint32_t> edges;
  if (!std::isfinite(deformation_.feature)) return edges;
  FaceSamples samples(deformation_, progress_);
  for (std::uint32_t f = 0; f < s_.face_count(); ++f) {
    stop_if_cancelled(progress_);
    const auto [a, b, c] = s_.triangle(f);
    samples.add(f, {s_.before[a], s_.before[b], s_.before[c]}, {s_.after[a], s_.after[b], s_.after[c]});
  }
  const std::optional<std::vector<std::uint32_t>> deviating = samples.deviating_faces(targets_.max_chord);
  if (!deviating) {
    if (may_refuse_) samples.refuse(targets_.max_vertices);
    return std::nullopt;
  }
  for (const std::uint32_t f : *deviating) {
    const std::uint32_t longest = s_.edge[longest_edge(s_, f, s_.after)];
    if (is_open(longest)) edges.push_back(longest);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Adds to each marked edge the longest edges of its very obtuse triangles. If such an edge cannot be split, neither is
// the marked edge: splitting only the shorter edges would make the triangles flatter and flatter.
std::vector<std::uint32_t> Refinement::with_longest_of_caps(const std::vector<std::uint32_t>& marked) const {
  std::vector<std::uint32_t> result;
  for (const std::uint32_t e : marked) {
    const std::uint32_t first = s_.halfedge[e];
    const std::size_t count = result.size();
    bool is_free = true;
    for (const std::uint32_t h : {first, s_.opposite[first]}) {
      if (h == kNone) continue;
      const std::uint32_t longest = longest_edge(s_, h / 3, s_.after);
      if (longest == h || !is_cap(s_, longest)) continue;
      is_free = is_free && is_open(s_.edge[longest]);
      if (!s_.edge_has(longest, kBoundary)) result.push_back(s_.edge[longest]);
    }
    if (is_free) {
      result.push_back(e);
    } else {
      result.resize(count);
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

void Refinement::split_edge(std::uint32_t e) {
  const std::uint32_t h = s_.halfedge[e];
  const std::uint32_t a = s_.origin(h);
  const std::uint32_t b = s_.target(h);
  const Vec3d before = (s_.before[a] + s_.before[b]) * 0.5;
  const Vec3d after = (s_.after[a] + s_.after[b]) * 0.5 + deviation_[e];
  const bool moves = is_moved(e);
  const std::uint32_t m = split(s_, h, before, after);
  if (moves) {
    s_.set(m, kMoved);
    s_.set(m, kRegion);
  }
  uncarried_.push_back(e);
  for (std::size_t n = deviation_.size(); n < s_.halfedge.size(); ++n)
    uncarried_.push_back(static_cast<std::uint32_t>(n));
  deviation_.resize(s_.halfedge.size());
  deviation_[e] = {};
  ++splits_;
}

Refinement::Round Refinement::split_round(const std::vector<bool>& forced) {
  if (!carry_middles()) return Round::stopped;
  std::vector<std::uint32_t> marked = find_marked(forced);
  if (marked.empty()) {
    std::optional<std::vector<std::uint32_t>> large = find_edges_of_large_faces();
    if (!large) return Round::stopped;
    marked = *std::move(large);
  }
  marked = with_longest_of_caps(marked);
  if (marked.empty()) return Round::met;
  if (!has_room(marked)) return Round::stopped;
  std::vector<std::pair<double, std::uint32_t>> longest_first;
  longest_first.reserve(marked.size());
  for (const std::uint32_t e : marked) longest_first.emplace_back(-length2(e, s_.after), e);
  std::sort(longest_first.begin(), longest_first.end());
  for (const auto& [length, e] : longest_first) {
    stop_if_cancelled(progress_);
    split_edge(e);
  }
  std::sort(uncarried_.begin(), uncarried_.end());
  uncarried_.erase(std::unique(uncarried_.begin(), uncarried_.end()), uncarried_.end());
  return Round::split;
}

}  // namespace knead::remesh_detail
