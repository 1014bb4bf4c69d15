// What a mask does to a segment. Internal to the library.
#pragma once

#include <span>
#include <vector>

#include "knead/flow.h"

namespace knead::detail {

// How the mask of a segment takes part in its fields.
struct SegmentMask {
  // Whether the mask is not 1 somewhere in the support of a field, at any time of [0, 1]. If not, the segment is as one
  // without a mask, bit for bit.
  bool acts = false;
  // What is taken from each field's vector potential. Of all constants it makes the flow that the mask adds the least,
  // in squares: along the border, where it is w grad m x (A - offset), and in the intermediate region, where it is
  // m dw/dr grad r x offset. Depends neither on begin and end nor on the limit cylinder.
  std::vector<Vec3d> offsets;
};

// Costs about 0.4 ms where the mask acts.
SegmentMask mask_on(const Segment& segment);

// The same for each part of a sum, given as parts_of() does. Where the parts are mirror images in coordinate planes, so
// are the constants that are taken from their potentials.
std::vector<SegmentMask> masks_on(const Segment& sum, const std::vector<Segment>& parts);

// The greatest speeds of a segment's flow at some points.
struct BorderSpeed {
  double at_border = 0;  // where m is neither 0 nor 1
  double of_tool = 0;    // anywhere, without the mask
};

// Looks at 3 moments; of a sum at each part by itself.
BorderSpeed border_speed(const Segment& segment, std::span<const Vec3d> points);

}  // namespace knead::detail
