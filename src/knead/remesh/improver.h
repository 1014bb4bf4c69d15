// The moves that improve triangles without changing the volume. Internal to the remesh room.
#pragma once

#include <span>
#include <vector>

#include "knead/remesh/improve.h"
#include "knead/remesh/shape.h"

namespace knead::remesh_detail {

// How far one change may go.
struct Bounds {
  double distance = 0;  // of what moves from the planes of the faces there, a length
  TurnLimit turn{};     // of a face
  double crease = 0;    // of what moves from a crease, a length
  double fold = 1;      // cosine of the greatest angle between a face that a flip makes and the two that were there
};

// The kinds of vertices, by what may move them.
enum class Freedom { free, on_crease, none };

class Improver {
 public:
  // With `soft_creases`, creases are as good as none.
  Improver(Surface& surface, const Improvement& improvement, bool soft_creases = false);

  Freedom freedom(std::uint32_t v) const;

  // Each does its change where that raises the least quality around to more than it was, and keeps to the bounds;
  // whether it did.
  bool flip_edge(std::uint32_t h, const Bounds& bounds);
  bool collapse_edge(std::uint32_t h, double least_quality, const Bounds& bounds);
  bool move_vertex(std::uint32_t v, const Bounds& bounds);
  // The same, looking for a better place in all directions.
  bool search_vertex(std::uint32_t v, const Bounds& bounds);
  // Takes the apex of a flat triangle, whose half-edge on a crease is given, into the crease.
  bool absorb_apex(std::uint32_t h, const Bounds& bounds);

  // Splits the edge in the middle of its chord, which leaves the surface where it is: between vertices that stand too
  // close to be merged, and far ones, the triangles then can be graded. Not below twice max_chord.
  bool split_chord(std::uint32_t h);

  // Spreads what could not be given back on the spot over all vertices that are free to move.
  void settle();

  Surface& surface() { return s_; }
  const ImprovementCounts& counts() const { return counts_; }

 private:
  struct Merge {
    std::uint32_t halfedge = kNone;  // whose origin goes
    Vec3d place{};
    double quality = -1;
    double volume = 0;  // six times what has to be given back
    double t = 0;       // of the edge, from the vertex that stays
  };

  bool is_open(std::uint32_t v) const;
  bool is_feature(std::uint32_t h) const;
  std::vector<std::uint32_t> movable(std::span<const std::uint32_t> vertices) const;
  // Moves all of these by one vector, so that six times the volume grows by `volume`. False where it would take more
  // than the tolerance, or turn a face.
  bool give_back(double volume, std::span<const std::uint32_t> vertices, const Bounds& bounds);
  std::vector<Merge> plan_merges(std::uint32_t h, const Bounds& bounds) const;
  bool move_to_best(std::uint32_t v, std::span<const Vec3d> places, const Bounds& bounds);
  void evaluate_merge(Merge& merge, const Bounds& bounds) const;
  bool is_straight(std::uint32_t v, double tolerance) const;
  void carry_values(std::uint32_t v, const Vec3d& p);

  Surface& s_;
  RemeshTargets targets_;
  std::vector<bool> locked_;
  bool soft_creases_ = false;
  ImprovementCounts counts_;
  double owed_ = 0;  // six times the volume that is to be given back
};

}  // namespace knead::remesh_detail
