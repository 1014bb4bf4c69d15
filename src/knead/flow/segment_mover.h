// How the points of a group are moved by one segment. Internal to the flow room.
#pragma once

#include <functional>

#include "knead/flow/advect.h"
#include "knead/flow/kernels_in_use.h"

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
};

// Moves the points of the blocks over the whole segment. Called from several threads.
using SegmentMover = std::function<GroupCounts(const LiveGroup& group)>;

// The segment must outlive what is returned. Of the options progress and steps are not looked at.
SegmentMover make_segment_mover(const Segment& segment, const AdvectOptions& options,
                                const KernelTable& kernels = kernels_in_use());

// For segments whose fields have no kernel.
template <class S>
SegmentMover path_lines_in(const Segment& segment, const AdvectOptions& options);

// Whether path lines of the segment go side by side through a kernel; the others are taken one by one.
bool has_kernel(const Segment& segment);

// How much of the intermediate region's width a step may pass, relative to which path lines' steps are chosen.
double reach_of_step(const Segment& segment);

// The estimate sees the error of each step, not how the flow's stretch magnifies it afterwards, and is too small where
// v is not smooth (at the inner threshold, and on the planes through a capsule's ends).
inline constexpr double kSafety = 0.02;

// Whether the fields' inner region moves with the tool.
bool carries(const Segment& segment);

}  // namespace knead::detail
