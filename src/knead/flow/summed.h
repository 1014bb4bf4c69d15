// Sums of segments: their parts, and the kernel that evaluates them together. Internal to the library.
#pragma once

#include <vector>

#include "knead/flow/segment_mover.h"

namespace knead::detail {

// Returns the segments whose velocities' sum is v: the parts of a sum, with its mask, beginning and end; of any other
// segment the segment itself.
std::vector<Segment> parts_of(const Segment& segment);

// Returns the flow with the parts of each sum one after the other. What one of them may move is what the flow may move,
// but it does not move points as the flow does.
Flow each_part(const Flow& flow);

// Returns whether no point is ever in the supports of two parts: they may move points one after the other, and exact
// facts about one (closed_form.h) hold for the sum. Barrels are not looked at.
bool act_apart(const Segment& sum);

// Returns whether a part has a barrel.
bool has_barrels(const Segment& segment);

// Returns the parts of a sum without their barrels that a mask of bits names, as a segment: a sum, or one part alone.
Segment chosen_parts(const Segment& sum, unsigned chosen);

// A kernel that evaluates the parts of a sum one after the other, each by the kernel that it has alone, and adds them
// up: what a part evaluates to has the bits that it has alone, and is exactly 0 outside its support. The order of the
// additions is such that v at the mirror image of a point is the mirror image of v, to the bit, where that is so of the
// parts. The segment must outlive it.
template <class S>
BoundKernel<S> sum_kernel(const Segment& sum, const AdvectOptions& options, const Kernels<S>& kernels);

// Returns how a part is evaluated alone. The segment must outlive it.
template <class S>
BoundKernel<S> kernel_of(const Segment& segment, double tolerance, const SegmentMask& mask, const Kernels<S>& kernels);

}  // namespace knead::detail
