// Functions that move a group's points by one segment: kernels with the fields that they read, and sums of segments by
// their parts. Internal to the library.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "flow/kernels/kernel.h"
#include "flow/masked.h"
#include "knead/flow.h"

namespace knead::detail {

// Moves the points of the blocks over the whole segment. Called from several threads.
using SegmentMover = std::function<GroupCounts(const LiveGroup& group)>;

// Moves a copy of the group's points. Returns x of all points, y of all, z of all.
std::vector<double> moved_copy(const SegmentMover& move, LiveGroup group);

// The segment must outlive the result. Ignores progress and steps of the options.
SegmentMover make_segment_mover(const Segment& segment, const AdvectOptions& options,
                                const KernelTable& kernels = kernels_in_use());

// The same with one kernel for all points; that of a sum evaluates all parts.
SegmentMover make_kernel_mover(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels);

// A kernel with the field that it reads; next_contact as in SegmentTask.
template <class S>
struct BoundKernel {
  FieldKernel<S> kernel;
  std::shared_ptr<const void> field;
  double (*next_contact)(const void* contact_data, const Vec3d& x, double t, const void*& cell) = nullptr;
  const void* contact_data = nullptr;
};

// Returns the kernel that evaluates a segment's path lines one by one (lane_kernel.cpp). The segment must outlive it.
template <class S>
BoundKernel<S> lane_kernel(const Segment& segment, double tolerance, const SegmentMask& mask);

// Returns the kernel of a segment that is neither pinned nor a sum. The segment must outlive it.
template <class S>
BoundKernel<S> kernel_of(const Segment& segment, double tolerance, const SegmentMask& mask, const Kernels<S>& kernels);

// Returns whether a kernel evaluates the segment's path lines in packs.
bool has_pack_kernel(const Segment& segment);

// A function that evaluates a field with its gradient in packs, and the field.
template <std::size_t variables>
struct BoundGradients {
  FindGradients<variables> find = nullptr;
  std::shared_ptr<const void> field;
};

// Returns null if no kernel evaluates the segment in packs.
BoundGradients<0> gradient_kernel(const Segment& segment, const SegmentMask& mask, const JacobianKernels<0>& kernels);

Method<double> method_in_double(Integrator integrator);

// Returns the task of a segment without its kernel. That of a sum limits steps by all of its parts.
SegmentTask<double> task_in_double(const Segment& segment, double tolerance);

// Returns the length that a step may pass; infinity between handles, where it depends on the place.
double reach_of_step(const Segment& segment);

// Returns whether the point, at t = 0, is in the limit cylinder.
bool is_within(const LimitCylinder& limit_cylinder, const Vec3d& x);

// Returns whether the inner region moves with the tool.
bool carries(const Segment& segment);

// Returns the segments whose sum of velocities is v: the parts of a sum with its mask, beginning and end, or the
// segment itself.
std::vector<Segment> parts_of(const Segment& segment);

// Returns, as bits, the parts without a limit cylinder and those whose limit cylinder contains the point at t = 0.
unsigned parts_around(std::span<const Segment> parts, const Vec3d& x);

// Returns the flow with the parts of each sum one after the other. It moves points differently, but together its
// segments may move the same points.
Flow each_part(const Flow& flow);

// Returns whether a part has a limit cylinder.
bool has_limit_cylinders(const Segment& segment);

// Returns the parts of a sum that the bits of `chosen` select, without their limit cylinders: a sum, or a single part.
Segment chosen_parts(const Segment& sum, unsigned chosen);

// Returns the kernel of a sum, which calls those of its parts (kernel_grid.h). `center`: the origin of its positions.
// The segment must outlive it.
template <class S>
BoundKernel<S> sum_kernel(const Segment& sum, const Vec3d& center, const AdvectOptions& options,
                          const Kernels<S>& kernels);

// Moves each point by the parts of a sum that it can meet and in whose limit cylinders it begins. A single part moves
// it as it does alone, also in closed form. Null if the segment is no sum, or if all parts move every point. The
// segment must outlive it.
SegmentMover mover_of_parts(const Segment& segment, const AdvectOptions& options, const KernelTable& kernels);

}  // namespace knead::detail
