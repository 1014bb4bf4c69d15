// Sums of segments: their parts, and how they move points. Internal to the library.
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

// Returns whether a part has a barrel.
bool has_barrels(const Segment& segment);

// Returns the parts of a sum without their barrels that a mask of bits names, as a segment: a sum, or one part alone.
Segment chosen_parts(const Segment& sum, unsigned chosen);

// The kernel of a sum, which calls those of its parts (kernel_sum.h). `center`: what positions are relative to. The
// segment must outlive it.
template <class S>
BoundKernel<S> sum_kernel(const Segment& sum, const Vec3d& center, const AdvectOptions& options,
                          const Kernels<S>& kernels);

// Moves each point by the parts that it can meet, in whose barrels it begins: by one part alone as that moves it
// without the others, with closed forms where there are any. Null for a segment that is no sum, and where every point
// is moved by all parts. The segment must outlive it.
SegmentMover mover_of_parts(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels);

}  // namespace knead::detail
