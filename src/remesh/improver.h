// Changes of a surface that improve triangles and keep the volume.
#pragma once

#include <span>
#include <vector>

#include "remesh/crossings.h"
#include "remesh/improve.h"
#include "remesh/surface.h"

namespace knead::remesh_detail {

// The limits of one change.
struct Bounds {
  double distance = 0;  // of a moved vertex from the planes of the faces around it; a length
  TurnLimit turn{};     // of each changed face
  double crease = 0;    // of a moved vertex from its crease; a length
  double fold = 1;      // cosine of the largest angle between the faces before and after a flip
};

// Where a vertex may move: anywhere, along its crease, or not at all.
enum class Freedom { free, on_crease, none };

class Improver {
 public:
  // With `bend_creases`, creases are treated like any other edge.
  Improver(Surface& surface, const Improvement& improvement, bool bend_creases = false);

  // Returns where the vertex may move.
  Freedom freedom(std::uint32_t v) const;

  // Each of the next five functions applies its change if it improves the worst triangle nearby and stays within
  // `bounds`. It returns true if it applied the change.

  // Replaces the edge of h by the other diagonal of its two faces.
  bool flip_edge(std::uint32_t h, const Bounds& bounds);
  // Collapses the edge of h if all triangles around it then have at least `least_quality`.
  bool collapse_edge(std::uint32_t h, double least_quality, const Bounds& bounds);
  // Moves the vertex towards the mean of its neighbours.
  bool move_vertex(std::uint32_t v, const Bounds& bounds);
  // Moves the vertex to the best of many positions in all tangential directions.
  bool search_vertex(std::uint32_t v, const Bounds& bounds);
  // Moves the apex of a thin triangle onto its opposite edge h, a crease, which then runs through the apex.
  bool merge_apex_into_crease(std::uint32_t h, const Bounds& bounds);

  // Splits the edge at the middle of its chord, which does not change the surface. Between vertices that are too close
  // together, but cannot be merged, and distant ones, sizes can then change gradually. Does not split edges shorter
  // than twice max_chord. Returns true if it split the edge.
  bool split_chord(std::uint32_t h);

  // Throws Cancelled if the improvement is cancelled.
  void stop_if_cancelled() const { knead::stop_if_cancelled(progress_); }

  // Returns whether the improvement has no time left, or its guard is spent. Throws Cancelled if it is cancelled.
  bool must_end() const {
    stop_if_cancelled();
    if (guard_ != nullptr && guard_->is_spent()) return true;
    return deadline_ != nullptr && deadline_->is_over();
  }

  Surface& surface() { return s_; }
  const ImprovementCounts& counts() const { return counts_; }

 private:
  struct Merge {
    std::uint32_t halfedge = kNone;  // its origin is removed
    Vec3d place{};
    double quality = -1;
    double volume = 0;  // six times the volume change that neighbours must compensate
    double t = 0;       // position of `place` along the edge, 0 at the kept vertex
  };

  bool is_open(std::uint32_t v) const;
  bool is_feature(std::uint32_t h) const;
  std::vector<std::uint32_t> movable(std::span<const std::uint32_t> vertices) const;
  // Moves all free vertices of the list by one vector, so that six times the volume grows by `volume`. Returns false
  // and moves nothing if that exceeds the bounds.
  bool restore_volume(double volume, std::span<const std::uint32_t> vertices, const Bounds& bounds);
  std::vector<Merge> plan_merges(std::uint32_t h, const Bounds& bounds) const;
  // Moves the vertex, whose star has been read, to the place that is best for its triangles.
  bool move_to_best(std::uint32_t v, std::span<const Vec3d> places, const Bounds& bounds);
  void evaluate_merge(Merge& merge, double least_quality, const Bounds& bounds) const;
  bool is_straight(std::uint32_t v, double tolerance) const;
  void carry_values(std::uint32_t v, const Vec3d& p);

  // Each of the next functions asks the guard, if there is one, whether a change may be applied.
  bool may_move(std::span<const std::uint32_t> vertices, const Vec3d& d) const;
  bool may_flip(std::uint32_t h) const;
  bool may_merge(const Merge& merge) const;
  bool may_merge_apex(std::uint32_t h, const Vec3d& foot) const;
  bool may_split(std::uint32_t h, const Vec3d& middle) const;
  // Tells the guard that the faces around the vertices have changed.
  void tell_guard(std::span<const std::uint32_t> vertices);

  Surface& s_;
  RemeshTargets targets_;
  const Progress* progress_ = nullptr;
  Deadline* deadline_ = nullptr;
  CrossingGuard* guard_ = nullptr;
  bool bend_creases_ = false;
  Star star_;
  ImprovementCounts counts_;
};

}  // namespace knead::remesh_detail
