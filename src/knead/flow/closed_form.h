// Path lines that need no integration (method, section 3, "Exact facts").
#pragma once

#include <optional>
#include <vector>

#include "knead/flow/segment.h"

namespace knead {

// Returns the displacement of the point x from segment.begin to segment.end where it is known in closed form, else
// nothing. The segment's barrel is ignored. Known are
//   - a translation swept along with its tool, for a point of the rigid inner region: the tool's displacement, exactly;
//   - a rotation in a ball about its centre, and a twist whose half-space's normal is parallel to its axis: every point
//     turns about the axis at a constant rate;
//   - the points of handles: those of the zero set rest, those of the full set follow the motion, exactly;
//   - a rotation, twist or symmetric strain, for points that stay in the inner region.
std::optional<Vec3d> closed_form(const Segment& segment, const Vec3d& x);

// The points of a segment's handles, sorted: the same answers for many x, each in the time of a binary search.
class HandlePoints {
 public:
  explicit HandlePoints(const Segment& segment);

  // Returns whether the segment has handles, and no other field.
  bool are_all() const { return !full_.empty(); }

  // Returns closed_form(segment, x) for the same segment, which must have handles alone.
  std::optional<Vec3d> closed_form(const Segment& segment, const Vec3d& x) const;

 private:
  std::vector<Vec3d> full_;
  std::vector<Vec3d> zero_;
};

}  // namespace knead
