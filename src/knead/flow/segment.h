// Segments and flows: deformations as plain values that contain no mesh (method, section 3).
#pragma once

#include <optional>
#include <vector>

#include "knead/field/field.h"

namespace knead {

// How a segment's fields depend on its time t in [0, 1].
//   swept:   they move with the tool's frame, c(t) = c + t displacement (and a half-space may turn);
//   blended: v(x, t) = (1 - t) v_c(x) + t v_{c + displacement}(x), two resting fields (paper, Eq. 9).
enum class TimeLaw { swept, blended };

// Moves only the points that are within `radius` of the line {point + s direction} at t = 0 of the segment.
struct Cylinder {
  Vec3d point;
  Vec3d direction;  // a unit vector
  double radius = 0;

  friend bool operator==(const Cylinder&, const Cylinder&) = default;
};

// The sum of one or more fields over one unit of time. The path lines run from t = begin to t = end, each in [0, 1]: 0
// to 1 is the whole segment, 1 to 0 its inverse, 0 to 0.5 its first half.
struct Segment {
  std::vector<Field> fields;
  Vec3d displacement{0, 0, 0};
  TimeLaw time_law = TimeLaw::swept;
  std::optional<Cylinder> cylinder;
  double begin = 0;
  double end = 1;

  friend bool operator==(const Segment&, const Segment&) = default;
};

struct Flow {
  std::vector<Segment> segments;

  friend bool operator==(const Flow&, const Flow&) = default;
};

// The flow that takes every point back.
Flow inverse(const Flow& flow);

// The part of the flow from its beginning to `segments` segments, 0 <= segments <= flow.segments.size(); a fraction
// ends within a segment.
Flow prefix(const Flow& flow, double segments);

// Throws InvalidInput, naming the segment, where a number is not finite, inner >= outer, an axis is not of unit length,
// a strain is not traceless, a point set is empty or its exponent not an even number of at least 2, blended is asked
// for anything but a translation of a ball or capsule, or begin or end lies outside [0, 1].
void validate(const Flow& flow);

}  // namespace knead
