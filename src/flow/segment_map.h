// The motion of a segment that is a map in closed form: of a curve's surroundings, or of the inside of a lattice.
// Internal to the library.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include "flow/curve_map.h"
#include "flow/lattice_map.h"
#include "flow/segment_mover.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// Returns whether the segment is such a map.
inline bool is_map(const Segment& segment) { return !segment.curve.is_empty() || !segment.lattice.is_empty(); }

// The map from the segment's beginning to its end.
class SegmentMap {
 public:
  using Status = CurveMap::Status;

  // is_map(segment). Throws InvalidInput if it has a mask that meets what it moves: no part can be held.
  explicit SegmentMap(const Segment& segment);

  Status move(Vec3d& x) const;
  // The same, with the Jacobian there.
  Status move(Vec3d& x, Mat3d& jacobian) const;

  // Returns the map of a lattice; null for a curve.
  const LatticeMap* lattice() const { return std::get_if<LatticeMap>(&map_); }

 private:
  std::variant<CurveMap, LatticeMap> map_;
};

// Moves a group's points by such a segment.
SegmentMover map_mover(const Segment& segment);

// Returns v at the points, for each unit of the segment's time t.
std::vector<Vec3d> map_velocities(const Segment& segment, std::span<const Vec3d> points, double t);

}  // namespace knead::detail
