// Splits edges until a mesh can follow a deformation, within limits on vertices and work.
#include "remesh/refine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "math/elementary.h"
#include "remesh/face_samples.h"
#include "remesh/surface.h"

namespace knead::detail {

namespace {

constexpr int kMaxRounds = 40;          // of limit_edges()
constexpr double kEstimateSlack = 4;    // factor by which the estimate may be too high where edges bend at one point
constexpr double kAdviceShare = 0.2;    // of the room: what the estimate may fill with the settings of a message
constexpr double kAdviceFactor = 4;     // the estimate grows while edges are split
constexpr double kPointsPerVertex = 4;  // a split makes four edges, whose middles are then carried
constexpr double kAdviceStep = 2;
constexpr int kMaxAdviceSteps = 60;

constexpr int kMaxLimitRounds = 60;
constexpr double kFeatureShare = 1.0 / 6;  // of max_chord: the target for features
constexpr double kCapCosine = -0.6;        // of 127 degrees: split the longest edge of such a triangle first
constexpr double kMinLengthShare = 1e-2;   // of max_chord: half the length below which edges are not split
constexpr double kMaxSlide = 0.25;         // of an edge: how far its middle may slide within a flat face

constexpr std::size_t kEdgeGrain = 8192;  // edges or vertices that a thread takes at a time

using LongEdge = std::pair<double, std::uint32_t>;  // its negated squared length, and its number

double length2(const Surface& s, std::uint32_t h) { return norm2(s.after[s.target(h)] - s.after[s.origin(h)]); }

// Returns the longest edge of the faces at an edge. Splitting a shorter one would not help.
std::uint32_t longest_around(const Surface& s, std::uint32_t e) {
  std::uint32_t longest = s.halfedge[e];
  const std::uint32_t first = longest;
  for (const std::uint32_t side : {first, s.opposite[first]}) {
    if (side == kNone) continue;
    for (const std::uint32_t h : {Surface::next(side), Surface::previous(side)}) {
      if (length2(s, h) > length2(s, longest)) longest = h;
    }
  }
  return s.edge[longest];
}

// Returns the edges that are too long, ascending.
std::vector<std::uint32_t> long_edges(const Surface& s, const RemeshOptions& options) {
  constexpr std::size_t grain = 8192;
  const double limit2 = options.targets.max_edge * options.targets.max_edge;
  std::vector<std::vector<std::uint32_t>> of_chunk(s.halfedge.size() / grain + 1);
  parallel_for(s.halfedge.size(), grain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const std::uint32_t h = s.halfedge[e];
      if (h == kNone || !s.is_alive(h / 3) || !(length2(s, h) > limit2)) continue;
      if (options.whole || s.has(s.origin(h), kMoved) || s.has(s.target(h), kMoved)) {
        of_chunk[begin / grain].push_back(static_cast<std::uint32_t>(e));
      }
    }
  });
  std::vector<std::uint32_t> found;
  for (const std::vector<std::uint32_t>& some : of_chunk) found.insert(found.end(), some.begin(), some.end());
  return found;
}

// Returns the edges to split for those that are too long, the longest first.
std::vector<LongEdge> edges_to_split(const Surface& s, const RemeshOptions& options, bool& has_locked) {
  std::vector<LongEdge> found;
  for (const std::uint32_t e : long_edges(s, options)) {
    const std::uint32_t longest = longest_around(s, e);
    if ((s.edge_flags[longest] & kLocked) != 0) {
      has_locked = true;
    } else {
      found.emplace_back(-length2(s, s.halfedge[longest]), s.first_copy(longest));
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

// Returns the sum of the area vectors of the faces around v.
Vec3d mean_normal(const Surface& s, std::uint32_t v, const std::vector<Vec3d>& positions) {
  Vec3d sum{};
  s.for_each_outgoing(v, [&](std::uint32_t h) { sum += area_vector(s, h / 3, positions); });
  return sum;
}

// Returns the mean normal of each end of the edges; zero for other vertices.
std::vector<Vec3d> mean_normals_of(const Surface& s, std::span<const std::uint32_t> edges, int threads) {
  std::vector<std::uint8_t> is_end(s.vertex_count(), 0);
  for (const std::uint32_t e : edges) is_end[s.origin(s.halfedge[e])] = is_end[s.target(s.halfedge[e])] = 1;
  std::vector<Vec3d> normals(s.vertex_count());
  parallel_for(normals.size(), kEdgeGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (is_end[v] != 0) normals[v] = mean_normal(s, static_cast<std::uint32_t>(v), s.after);
    }
  });
  return normals;
}

// Returns true if the angle opposite to the half-edge is very obtuse.
bool is_cap(const Surface& s, std::uint32_t h) {
  const Vec3d& apex = s.after[s.apex(h)];
  const Vec3d u = s.after[s.origin(h)] - apex;
  const Vec3d v = s.after[s.target(h)] - apex;
  return dot(u, v) < kCapCosine * norm(u) * norm(v);
}

// Returns the squared cosine of an angle that is below the given one and below 90 degrees by more than rounding errors.
double flat_cosine2(double angle) {
  constexpr double margin = 1e-9;
  const double cosine = angle < std::numbers::pi / 2 ? elementary::cos(angle) : 0.0;
  return cosine * cosine * (1 + margin) + margin;
}

double angle_between(const Vec3d& a, const Vec3d& b) { return elementary::atan2(norm(cross(a, b)), dot(a, b)); }

}  // namespace

LimitedEdges limit_edges(Surface& s, const RemeshOptions& options, std::size_t outside, std::optional<Surface>& was) {
  LimitedEdges result;
  for (int round = 0;; ++round) {
    stop_if_cancelled(options.progress);
    bool has_locked = false;
    const std::vector<LongEdge> edges = edges_to_split(s, options, has_locked);
    const bool has_room =
        s.vertex_count() + outside + edges.size() <= options.targets.max_vertices && round < kMaxRounds;
    if (edges.empty() || !has_room) {
      result.met = edges.empty() && !has_locked;
      return result;
    }
    if (!was) was = s;
    for (const auto& [length, e] : edges) {
      const std::uint32_t h = s.halfedge[e];
      const std::uint32_t a = s.origin(h);
      const std::uint32_t b = s.target(h);
      const std::uint32_t m = split(s, h, (s.before[a] + s.before[b]) * 0.5, (s.after[a] + s.after[b]) * 0.5);
      if (s.has(a, kMoved) || s.has(b, kMoved)) s.set(m, kMoved);
      ++result.splits;
    }
  }
}

double Refinement::points_left() const { return deformation_.points_left ? deformation_.points_left() : kInfinity; }

// Returns the number of vertices that the surface may have.
double Refinement::room() const {
  const double by_cap = static_cast<double>(targets_.max_vertices) - outside_;
  return std::min(by_cap, static_cast<double>(s_.vertex_count()) + points_left() / kPointsPerVertex);
}

// Returns about how many pieces the edge needs, by the length of its image and by its deviation: that of a piece falls
// with the square of their number.
double Refinement::pieces(std::uint32_t e, const Slack& slack) const {
  const std::uint32_t h = s_.halfedge[e];
  const Vec3d half = (s_.after[s_.target(h)] - s_.after[s_.origin(h)]) * 0.5;
  const double length = norm(half + deviation_[e]) + norm(half - deviation_[e]);
  const double by_length = length / (targets_.max_edge * slack.edge);
  const double by_chord = std::sqrt(distance_from_image(e) / (targets_.max_chord * slack.chord));
  const double max_pieces = std::min(length, std::sqrt(length2(e, s_.before))) / min_length_;
  return std::max(1.0, std::min(std::max(by_length, by_chord), max_pieces));
}

// Returns about how many vertices the surface has once these edges, ascending, and the faces at them are divided.
double Refinement::estimate(std::span<const std::uint32_t> edges, const Slack& slack) const {
  double vertices = static_cast<double>(s_.vertex_count());
  std::vector<std::uint32_t> faces;
  for (const std::uint32_t e : edges) {
    vertices += pieces(e, slack) - 1;
    const std::uint32_t h = s_.halfedge[e];
    faces.push_back(h / 3);
    if (s_.opposite[h] != kNone) faces.push_back(s_.opposite[h] / 3);
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  const auto count = [&](std::uint32_t e) {
    return std::binary_search(edges.begin(), edges.end(), e) ? pieces(e, slack) : 1.0;
  };
  for (const std::size_t f : faces) {
    std::array<double, 3> at{count(s_.edge[3 * f]), count(s_.edge[3 * f + 1]), count(s_.edge[3 * f + 2])};
    std::sort(at.begin(), at.end());
    vertices += (at[0] - 1) * (at[1] - 1) / 2;
  }
  return vertices;
}

// Returns false, or throws RemeshLimit, if the next round or all of them would exceed the limits.
bool Refinement::has_room(std::span<const std::uint32_t> marked) {
  const double next = static_cast<double>(s_.vertex_count() + marked.size());
  const double all = estimate(marked, {});
  if (next <= room() && all <= kEstimateSlack * room()) return true;
  if (may_refuse_) refuse(marked, std::max(next, all));
  return false;
}

// Returns the settings with which the estimate is at most `max_vertices`, as words of a message.
std::string Refinement::remedy(std::span<const std::uint32_t> edges, double max_vertices) const {
  double slack = 1;
  for (int step = 0; step < kMaxAdviceSteps; ++step) {
    slack *= kAdviceStep;
    std::string edge = fmt::format("\"max_edge\" of {:.2g} or more", slack * targets_.max_edge);
    const double longer = slack * slack * targets_.max_chord / targets_.diagonal;
    std::string chord = fmt::format("\"max_chord\" of {:.2g} or more", longer);
    if (estimate(edges, {slack, 1}) <= max_vertices) return edge;
    if (longer >= 1) continue;
    if (estimate(edges, {1, slack * slack}) <= max_vertices) return chord;
    if (estimate(edges, {slack, slack * slack}) <= max_vertices) return fmt::format("{} with {}", edge, chord);
  }
  return {};
}

void Refinement::refuse(std::span<const std::uint32_t> edges, double needed) const {
  const double now = static_cast<double>(s_.vertex_count());
  const bool is_work = static_cast<double>(targets_.max_vertices) - outside_ > room();
  const std::string settings = remedy(edges, std::max(kAdviceShare * room(), now + 1));
  double figure = std::max(needed, now + static_cast<double>(edges.size()));
  std::string text = fmt::format("the mesh needs about {:.2g} vertices", outside_ + figure);
  if (!whole_) text += " to follow this stroke";
  if (is_work) {
    const double left = std::max(0.0, points_left());
    figure = static_cast<double>(targets_.max_vertices) * (carried_ + kPointsPerVertex * figure) /
             std::max(1.0, carried_ + left);
    text += fmt::format(", more work than \"max_vertices\" ({}) allows", targets_.max_vertices);
  } else {
    figure += outside_;
    text += fmt::format(", more than \"max_vertices\" ({}) allows", targets_.max_vertices);
  }
  text += settings.empty() ? "; deform less" : "; use a " + settings;
  if (kAdviceFactor * figure <= static_cast<double>(kMaxVertices)) {
    text += fmt::format(", or \"max_vertices\": {:.0f}", std::ceil(kAdviceFactor * figure));
  }
  throw RemeshLimit(text);
}

Refinement::Refinement(Surface& surface, const Deformation& deformation, const RemeshOptions& options,
                       std::size_t outside, Deadline& deadline)
    : s_(surface),
      deformation_(deformation),
      targets_(options.targets),
      whole_(options.whole),
      threads_(options.threads),
      progress_(options.progress),
      deadline_(deadline),
      min_length_(kMinLengthShare * options.targets.max_chord),
      flat_cosine2_(flat_cosine2(options.targets.max_angle)),
      outside_(static_cast<double>(outside)) {
  deviation_.reserve(s_.halfedge.capacity());
  deviation_.resize(s_.halfedge.size());
  if (options.targets.iterations > 0 && std::count(s_.of_part.begin(), s_.of_part.end(), 1) > 0) flat_.emplace(s_);
  uncarried_.reserve(s_.halfedge.size());
  for (std::uint32_t e = 0; e < s_.halfedge.size(); ++e) {
    if ((s_.edge_flags[e] & kLocked) == 0) uncarried_.push_back(e);
  }
}

bool Refinement::split_rounds() {
  for (int round = 0; round < kMaxLimitRounds; ++round) {
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

// Carries the middles of new edges. Returns false if that would be too much work.
bool Refinement::carry_middles() {
  if (static_cast<double>(uncarried_.size()) > points_left()) {
    if (may_refuse_) refuse(uncarried_, 0);
    return false;
  }
  std::vector<Vec3d> points(uncarried_.size());
  const auto middle = [&](std::size_t i, const std::vector<Vec3d>& positions) {
    const std::uint32_t h = s_.halfedge[uncarried_[i]];
    return (positions[s_.origin(h)] + positions[s_.target(h)]) * 0.5;
  };
  parallel_for(points.size(), kEdgeGrain, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) points[i] = middle(i, s_.before);
  });
  deformation_.carry(points);
  carried_ += static_cast<double>(points.size());
  parallel_for(points.size(), kEdgeGrain, threads_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) deviation_[uncarried_[i]] = points[i] - middle(i, s_.after);
  });
  untested_.insert(untested_.end(), uncarried_.begin(), uncarried_.end());
  uncarried_.clear();
  return true;
}

// Returns true if the edge may be split: it is not locked and not too short.
bool Refinement::is_open(std::uint32_t e) const {
  return (s_.edge_flags[e] & kLocked) == 0 &&
         std::min(length2(e, s_.before), length2(e, s_.after)) > 4 * min_length_ * min_length_;
}

bool Refinement::is_moved(std::uint32_t e) const {
  const std::uint32_t a = s_.origin(s_.halfedge[e]);
  const std::uint32_t b = s_.target(s_.halfedge[e]);
  return deviation_[e] != Vec3d{} || s_.before[a] != s_.after[a] || s_.before[b] != s_.after[b];
}

// Returns how far a point is from a face that should be there. On a flat face of a part it does not count that the
// point slides within the face: the surface stays the same. Values that points have would slide, too.
double Refinement::distance_from_face(std::uint32_t f, const Vec3d& deviation) const {
  const std::uint32_t longest = longest_edge(s_, f, s_.after);
  const double length2 = norm2(s_.after[s_.target(longest)] - s_.after[s_.origin(longest)]);
  const Vec3d n = area_vector(s_, f, s_.after);
  const bool counts = s_.has_attributes || !s_.is_of_part(f) || !(norm2(n) > 0);
  if (counts || !(norm2(deviation) < kMaxSlide * kMaxSlide * length2)) return norm(deviation);
  return std::abs(dot(deviation, n)) / norm(n);
}

// Returns how far the edge is from its image in the middle, which may slide along an edge between flat faces of parts.
double Refinement::distance_from_image(std::uint32_t e) const {
  const std::uint32_t h = s_.halfedge[e];
  const std::uint32_t o = s_.opposite[h];
  const Vec3d& d = deviation_[e];
  const Vec3d edge = s_.after[s_.target(h)] - s_.after[s_.origin(h)];
  const bool is_between_parts = o != kNone && s_.is_of_part(h / 3) && s_.is_of_part(o / 3);
  if (s_.has_attributes || !is_between_parts || !(norm2(d) < kMaxSlide * kMaxSlide * norm2(edge))) return norm(d);
  if ((s_.edge_flags[e] & (kFeature | kBend)) != 0) return norm(cross(d, edge)) / norm(edge);
  return std::max(distance_from_face(h / 3, d), distance_from_face(o / 3, d));
}

bool Refinement::needs_split(std::uint32_t e, const std::vector<Vec3d>& normals) const {
  const bool is_feature = (s_.edge_flags[e] & kFeature) != 0;
  const double chord = targets_.max_chord * (is_feature ? kFeatureShare : 1.0);
  if (distance_from_image(e) > chord) return true;
  const bool moves = is_moved(e);
  if (!moves && !whole_) return false;
  const double size2 = length2(e, s_.after);
  if (size2 > targets_.max_edge * targets_.max_edge) return true;
  // Splits of boundaries depend on their two ends only: coincident boundaries are then split equally.
  if (!moves || (s_.edge_flags[e] & kBoundary) != 0 || size2 < targets_.min_edge * targets_.min_edge) return false;
  const std::uint32_t a = s_.origin(s_.halfedge[e]);
  const std::uint32_t b = s_.target(s_.halfedge[e]);
  const Vec3d& n = normals[a];
  const Vec3d& m = normals[b];
  const double along = dot(n, m);
  if (along > 0 && along * along > flat_cosine2_ * (norm2(n) * norm2(m))) return false;
  const double was = angle_between(mean_normal(s_, a, s_.before), mean_normal(s_, b, s_.before));
  return angle_between(n, m) > targets_.max_angle + was;
}

std::vector<std::uint32_t> Refinement::find_marked(const std::vector<bool>& forced) {
  std::vector<std::uint32_t> marked;
  if (untested_.empty()) return marked;
  if (!std::is_sorted(untested_.begin(), untested_.end())) std::sort(untested_.begin(), untested_.end());
  untested_.erase(std::unique(untested_.begin(), untested_.end()), untested_.end());
  const std::vector<Vec3d> normals = mean_normals_of(s_, untested_, threads_);
  std::vector<std::vector<std::uint32_t>> of_chunk(untested_.size() / kEdgeGrain + 1);
  parallel_for(untested_.size(), kEdgeGrain, threads_, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress_);
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t e = untested_[i];
      if (!is_open(e)) continue;
      if ((e < forced.size() && forced[e]) || needs_split(e, normals)) of_chunk[begin / kEdgeGrain].push_back(e);
    }
  });
  for (const std::vector<std::uint32_t>& some : of_chunk) marked.insert(marked.end(), some.begin(), some.end());
  untested_.clear();
  return marked;
}

// Returns the longest edges of faces that are large compared with the deformation and bend inside; nothing if sampling
// them would be too much work.
std::optional<std::vector<std::uint32_t>> Refinement::find_edges_of_large_faces() const {
  std::vector<std::uint32_t> edges;
  if (!std::isfinite(deformation_.feature)) return edges;
  FaceSamples samples(deformation_, progress_);
  for (std::uint32_t f = 0; f < s_.face_count(); ++f) {
    stop_if_cancelled(progress_);
    const auto [a, b, c] = s_.triangle(f);
    samples.add(f, {s_.before[a], s_.before[b], s_.before[c]}, {s_.after[a], s_.after[b], s_.after[c]});
  }
  const std::optional<std::vector<std::uint32_t>> deviating = samples.deviating_faces(
      targets_.max_chord, [&](std::uint32_t f, const Vec3d& d) { return distance_from_face(f, d); });
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
      const bool is_alone = s_.edge_has(longest, kBoundary) && !s_.has_copies(s_.edge[longest]);
      if (!is_alone) result.push_back(s_.edge[longest]);
    }
    if (is_free) {
      result.push_back(e);
    } else {
      result.resize(count);
    }
  }
  for (std::uint32_t& e : result) e = s_.first_copy(e);
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
  s_.for_each_copy(e, [&](std::uint32_t c) {
    deviation_[c] = {};
    uncarried_.push_back(c);
  });
  const std::size_t faces = s_.face_count();
  const std::uint32_t o = s_.opposite[h];
  const std::uint32_t m = split(s_, h, before, after);
  if (flat_) {
    flat_->unsettle(h / 3);
    if (o != kNone) flat_->unsettle(o / 3);
    for (std::size_t f = faces; f < s_.face_count(); ++f) flat_->unsettle(static_cast<std::uint32_t>(f));
  }
  if (moves) {
    s_.set(m, kMoved);
    s_.set(m, kRegion);
  }
  for (std::size_t n = deviation_.size(); n < s_.halfedge.size(); ++n)
    uncarried_.push_back(static_cast<std::uint32_t>(n));
  deviation_.resize(s_.halfedge.size());
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
  if (flat_) {
    flips_ += flat_->settle([&](std::uint32_t d) {
      deviation_[s_.edge[d]] = {};
      uncarried_.push_back(s_.edge[d]);
    });
  }
  std::sort(uncarried_.begin(), uncarried_.end());
  uncarried_.erase(std::unique(uncarried_.begin(), uncarried_.end()), uncarried_.end());
  return Round::split;
}

}  // namespace knead::detail
