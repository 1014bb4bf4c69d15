// Changes of a surface that improve triangles and keep the volume.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "remesh/crossings.h"
#include "remesh/improve.h"
#include "remesh/surface.h"

namespace knead::detail {

inline constexpr double kKeptQuality = 0.9;  // share of what a face of a part had that is good enough

// The limits of one change.
struct Bounds {
  double distance = 0;  // of a moved vertex from the planes of the faces around it; a length
  TurnLimit turn{};     // of each changed face
  double crease = 0;    // of a moved vertex from its crease; a length
  double fold = 1;      // cosine of the largest angle between the faces before and after a flip
};

// Where a vertex may move: anywhere, along its crease, or not at all.
enum class Freedom { free, on_crease, none };

// Remembers qualities of faces and refused attempts, so that nothing is computed again where nothing has changed.
class SurfaceMemory {
 public:
  // Measures the faces that are not known, and forgets which edges and vertices rest. Must be called first.
  void begin(const Surface& s, int threads);

  // Measures the faces that are not known.
  void measure(const Surface& s, int threads);

  // Returns quality(s, f, s.after). Several threads may ask for faces that are known.
  double quality(const Surface& s, std::size_t f) {
    double& known = quality_[f];
    if (known < 0) known = detail::quality(s, f, s.after);
    return known;
  }

  // An edge or vertex rests if no change of it can be an improvement until a face at it changes.
  bool edge_rests(std::size_t e) const { return edge_rests_[e] != 0; }
  bool vertex_rests(std::size_t v) const { return vertex_rests_[v] != 0; }
  void let_edge_rest(std::size_t e) { edge_rests_[e] = 1; }
  void let_vertex_rest(std::size_t v) { vertex_rests_[v] = 1; }

  // Begins a round of repairs in one thread, by splits as well or without. A repair that was refused would be refused
  // again by the same means until a star changes, of a corner or of a neighbour of one.
  void begin_repairs(bool may_split) {
    ++round_;
    if (std::exchange(splits_, may_split) != may_split) std::fill(refused_.begin(), refused_.end(), 0);
  }
  bool is_refused(const Surface& s, std::uint32_t f) const {
    const Triangle t = s.triangle(f);
    return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return changed_[v] < refused_[f]; });
  }
  void refuse(std::uint32_t f) { refused_[f] = round_; }

  // Must be called first after a split.
  void add_new(const Surface& s);
  // Must be called when the faces around v have changed.
  void forget_around(const Surface& s, std::uint32_t v);

 private:
  std::vector<double> quality_;  // of each face; below 0: not known
  std::vector<std::uint8_t> edge_rests_;
  std::vector<std::uint8_t> vertex_rests_;
  std::uint32_t round_ = 0;  // of repairs, from 1; 0: not repairing
  bool splits_ = false;
  std::vector<std::uint32_t> refused_;  // of each face: the last round in which its repair was refused; 0: none
  std::vector<std::uint32_t> changed_;  // of each vertex: the last round in which its star or a neighbour's changed
};

// The result of an attempt to change a surface.
enum class Attempt {
  done,
  refused,
  impossible,  // until a face around it changes
};

class Improver {
 public:
  Improver(Surface& surface, const Improvement& improvement);

  // Returns where the vertex may move.
  Freedom freedom(std::uint32_t v) const;

  // Each of the next five functions applies its change if it improves the worst triangle nearby and stays within
  // `bounds`. It returns true if it applied the change.

  // Replaces the edge of h by the other diagonal of its two faces.
  bool flip_edge(std::uint32_t h, const Bounds& bounds) { return gains_by_flip(h) && try_flip(h, bounds); }
  // Collapses the edge of h if all triangles around it then have at least this quality, which it asks for only where
  // the edge may be collapsed.
  bool collapse_edge(std::uint32_t h, const std::function<double()>& least_quality, const Bounds& bounds);
  // Moves the vertex towards the mean of its neighbours.
  Attempt move_vertex(std::uint32_t v, const Bounds& bounds);
  // Moves the vertex to the best of many positions in all tangential directions.
  bool search_vertex(std::uint32_t v, const Bounds& bounds);
  // Moves the apex of a thin triangle onto its opposite edge h, a feature, which then runs through the apex.
  bool merge_apex_into_crease(std::uint32_t h, const Bounds& bounds);

  // Splits the edge at the middle of its chord, which does not change the surface, unless the edge is shorter than
  // twice max_chord. Sizes can then change gradually between vertices that are too close together, but cannot be
  // merged, and distant ones. Returns true if it split the edge.
  bool split_chord(std::uint32_t h);

  // The first part of flip_edge(): returns true if a flip is allowed and improves the two faces.
  bool gains_by_flip(std::uint32_t h);
  // The second part: flips an edge that gains by it, if the flip stays within the bounds.
  bool try_flip(std::uint32_t h, const Bounds& bounds);

  // Returns quality(surface, face, surface.after).
  double quality_of(std::uint32_t face) {
    return memory_ != nullptr ? memory_->quality(s_, face) : quality(s_, face, s_.after);
  }

  // Returns true if the quality is below this and, in a part, below what keep_part_quality() has kept.
  bool is_poor(std::uint32_t face, double below) {
    const double q = quality_of(face);
    return q < below && (s_.quality_before.empty() || q < kKeptQuality * s_.quality_before[face]);
  }

  // Throws Cancelled if the improvement is cancelled.
  void stop_if_cancelled() const { knead::stop_if_cancelled(progress_); }

  // Returns true if no time is left or the guard is spent. Throws Cancelled if the improvement is cancelled.
  bool must_end() const {
    stop_if_cancelled();
    if (guard_ != nullptr && guard_->is_spent()) return true;
    return deadline_ != nullptr && deadline_->is_over();
  }

  Surface& surface() { return s_; }
  const ImprovementCounts& counts() const { return counts_; }
  // Adds what another improver of the surface has done.
  void add(const ImprovementCounts& counts) { counts_ += counts; }

 private:
  struct Merge {
    std::uint32_t halfedge = kNone;  // its origin is removed
    Vec3d place{};
    double quality = -1;
    double volume = 0;  // six times the volume change that neighbours must compensate
    double t = 0;       // position of `place` along the edge, 0 at the kept vertex
  };

  // Informs the guard and the memory that the faces around the vertices have changed.
  void report_change(std::span<const std::uint32_t> vertices);
  // Reads the star of the vertex, and returns where it may move.
  Freedom read_star(std::uint32_t v);
  // Calls visit(h) for the half-edges that begin at the vertex, until they are too many.
  template <class Visit>
  Freedom freedom(std::uint32_t v, Visit visit) const;
  bool is_open(std::uint32_t v) const;
  bool is_helped_by_split(std::uint32_t h) const;
  bool is_feature(std::uint32_t h) const { return s_.edge_has(h, kFeature) || (exact_ && s_.edge_has(h, kBend)); }
  // Returns true if a face around v would turn too far with v at p. `star`: the star vector of v.
  bool any_turns(std::uint32_t v, const Vec3d& p, const Vec3d& star, const TurnLimit& limit);
  // Moves all free vertices of the list by one vector, so that six times the volume grows by `volume`. Returns false
  // and moves nothing if that exceeds the bounds.
  bool restore_volume(double volume, std::span<const std::uint32_t> vertices, const Bounds& bounds);
  std::vector<Merge> plan_merges(std::uint32_t h, const Bounds& bounds) const;
  // Moves the vertex, whose star has been read, to the position that is best for its triangles.
  Attempt move_to_best(std::uint32_t v, std::span<const Vec3d> places, const Bounds& bounds);
  void evaluate_merge(Merge& merge, double least_quality, const Bounds& bounds) const;
  bool is_straight(std::uint32_t v, double tolerance) const;
  void carry_values(std::uint32_t v, const Vec3d& p);

  // Each of the next functions returns true if there is no guard, or the guard allows the change.
  bool may_move(std::span<const std::uint32_t> vertices, const Vec3d& d) const;
  bool may_flip(std::uint32_t h) const;
  bool may_merge(const Merge& merge) const;
  bool may_merge_apex(std::uint32_t h, const Vec3d& foot) const;
  bool may_split(std::uint32_t h, const Vec3d& middle) const;

  Surface& s_;
  RemeshTargets targets_;
  const Progress* progress_ = nullptr;
  Deadline* deadline_ = nullptr;
  CrossingGuard* guard_ = nullptr;
  SurfaceMemory* memory_ = nullptr;
  bool exact_ = false;
  bool may_collapse_ = true;
  Star star_;
  std::vector<std::uint32_t> moving_;  // by restore_volume()
  std::vector<Vec3d> moving_stars_;
  ImprovementCounts counts_;
};

// Divides the vertices of a surface into blocks that several threads change at the same time. A change at a vertex
// whose neighbours are all in its block reads and writes no other block; a flip needs four such vertices.
class Blocks {
 public:
  Blocks(const Surface& s, int threads);

  // Finds the vertices whose neighbours are all in their block. Must be called after a change.
  void find_inner(const Surface& s);

  // Return the block that contains everything a change at the vertex, or a flip of the edge, touches; the number of
  // blocks if there is none.
  std::uint32_t around(std::uint32_t v) const { return inner_[v] != 0 ? block_[v] : count_; }
  std::uint32_t around_edge(const Surface& s, std::uint32_t e) const {
    const std::uint32_t h = s.halfedge[e];
    if (h == kNone || s.opposite[h] == kNone) return count_;
    return std::max({around(s.origin(h)), around(s.target(h)), around(s.apex(h)), around(s.apex(s.opposite[h]))});
  }

  // Calls change(improver, i) for each number i with a block other than kNone: for the numbers of each block in order,
  // several blocks at the same time; then for those that belong to no single block.
  template <class Change>
  void change_all(Improver& improver, const Improvement& improvement, std::span<const std::uint32_t> block,
                  const Change& change) const {
    std::vector<std::vector<std::uint32_t>> of_block(count_ + std::size_t{1});
    for (std::uint32_t i = 0; i < block.size(); ++i) {
      if (block[i] != kNone) of_block[block[i]].push_back(i);
    }
    const auto run = [&](Improver& by, const std::vector<std::uint32_t>& numbers) {
      for (const std::uint32_t i : numbers) {
        if (by.must_end()) break;
        change(by, i);
      }
    };
    std::vector<ImprovementCounts> counts(count_);
    const int threads = improvement.guard == nullptr ? improvement.threads : 1;
    parallel_for(count_, 1, threads, [&](std::size_t i, std::size_t) {
      Improver own(improver.surface(), improvement);
      run(own, of_block[i]);
      counts[i] = own.counts();
    });
    for (const ImprovementCounts& some : counts) improver.add(some);
    run(improver, of_block[count_]);
  }

 private:
  std::uint32_t count_ = 1;
  std::vector<std::uint32_t> block_;  // of each vertex
  std::vector<std::uint8_t> inner_;   // of each vertex: 1 if its neighbours are in its block
};

}  // namespace knead::detail
