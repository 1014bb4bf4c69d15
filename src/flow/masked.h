// The effect of a mask on a segment. Internal to the library.
#pragma once

#include <span>
#include <vector>

#include "knead/flow.h"

namespace knead::detail {

// The mask of a segment, applied to its fields.
struct SegmentMask {
  // Whether the mask is not 1 somewhere in the support of a field, at some time of [0, 1]. Otherwise the segment gives
  // the bits of one without a mask.
  bool acts = false;
  // The constants that are subtracted from each field's vector potential. They minimise the flow that the mask adds, in
  // squares: w grad m x (A - offset) along the border, and m dw/dr grad r x offset in the intermediate region. They do
  // not depend on begin, end and the limit cylinder.
  std::vector<Vec3d> offsets;
};

// Costs about 0.4 ms where the mask acts.
SegmentMask mask_on(const Segment& segment);

// The same for each of parts_of(sum). If the parts are mirror images in coordinate planes, so are their offsets.
std::vector<SegmentMask> masks_on(const Segment& sum, const std::vector<Segment>& parts);

// The greatest speeds of a segment's flow at some points.
struct BorderSpeed {
  double at_border = 0;  // where 0 < m < 1
  double of_tool = 0;    // anywhere, without the mask
};

// Evaluates v at 3 times, for each part of a sum alone.
BorderSpeed border_speed(const Segment& segment, std::span<const Vec3d> points);

}  // namespace knead::detail
