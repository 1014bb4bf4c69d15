// How the points of a group are moved by one segment.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "flow/kernels/kernel.h"
#include "flow/masked.h"
#include "knead/flow.h"

namespace knead::detail {

// The live blocks of a group. As GroupTask of the kernels, in either precision.
struct LiveGroup {
  Coordinates points;                      // kGroup of each
  const std::uint64_t* members = nullptr;  // by block: which lanes hold points
  const std::uint16_t* blocks = nullptr;
  int block_count = 0;
  std::uint64_t between = 0;       // by block: whether all points are known to be between the inner and outer region
  std::uint32_t* steps = nullptr;  // kGroup, to which accepted steps are added
  double* moved = nullptr;         // by block: raised to how far a point of it moves along an axis, at most
  CancelCheck stop;
};

// Moves the points of the blocks over the whole segment. Called from several threads.
using SegmentMover = std::function<GroupCounts(const LiveGroup& group)>;

// The segment must outlive what is returned. Of the options progress and steps are not looked at.
SegmentMover make_segment_mover(const Segment& segment, const AdvectOptions& options,
                                const KernelTable& kernels = kernels_in_use());

// The same with one kernel for all points: of a sum the one that evaluates all parts.
SegmentMover make_kernel_mover(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels);

// A kernel with the field that it reads.
template <class S>
struct BoundKernel {
  FieldKernel<S> kernel;
  std::shared_ptr<const void> field;
  // As SegmentTask has them.
  double (*next_contact)(const void* contact_data, const Vec3d& x, double t, const void*& cell) = nullptr;
  const void* contact_data = nullptr;
};

// The kernel that evaluates a segment's path lines one by one (lane_kernel.h). The segment must outlive it.
template <class S>
BoundKernel<S> lane_kernel(const Segment& segment, double tolerance, const SegmentMask& mask);

// Returns how a segment that is neither pinned nor a sum is evaluated. The segment must outlive it.
template <class S>
BoundKernel<S> kernel_of(const Segment& segment, double tolerance, const SegmentMask& mask, const Kernels<S>& kernels);

// Whether a kernel evaluates the segment's path lines in packs.
bool has_pack_kernel(const Segment& segment);

// What evaluates a field with its gradient in packs, and the field that it reads.
struct BoundGradients {
  FindGradients find = nullptr;
  std::shared_ptr<const void> field;
};

// Null where there is no kernel for it.
BoundGradients gradient_kernel(const Segment& segment, const SegmentMask& mask, const JacobianKernels& kernels);

Method<double> method_in_double(Integrator integrator);

// What a segment asks of a kernel, which is left out. Of a sum: for those who know no limits of the parts.
SegmentTask<double> task_in_double(const Segment& segment, double tolerance);

// How far a step may pass, a length; infinity between handles, where that depends on the place.
double reach_of_step(const Segment& segment);

// Whether the point is in the limit cylinder, at t = 0.
bool is_within(const LimitCylinder& limit_cylinder, const Vec3d& x);

// Whether the fields' inner region moves with the tool.
bool carries(const Segment& segment);

// Sums of segments: their parts, and how they move points. Internal to the library.

// Returns the segments whose velocities' sum is v: the parts of a sum, with its mask, beginning and end; of any other
// segment the segment itself.
std::vector<Segment> parts_of(const Segment& segment);

// Returns the flow with the parts of each sum one after the other. What one of them may move is what the flow may move,
// but it does not move points as the flow does.
Flow each_part(const Flow& flow);

// Returns whether a part has a limit cylinder.
bool has_limit_cylinders(const Segment& segment);

// Returns the parts of a sum without their limit cylinders that a mask of bits names, as a segment: a sum, or one part
// alone.
Segment chosen_parts(const Segment& sum, unsigned chosen);

// The kernel of a sum, which calls those of its parts (kernel_grid.h). `center`: what positions are relative to. The
// segment must outlive it.
template <class S>
BoundKernel<S> sum_kernel(const Segment& sum, const Vec3d& center, const AdvectOptions& options,
                          const Kernels<S>& kernels);

// Moves each point by the parts that it can meet, in whose limit cylinders it begins: by one part alone as that moves
// it without the others, with closed forms where there are any. Null for a segment that is no sum, and where every
// point is moved by all parts. The segment must outlive it.
SegmentMover mover_of_parts(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels);

}  // namespace knead::detail
