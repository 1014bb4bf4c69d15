// Moves points in blocks through a flow, with a bound on the work. Internal to the library.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "flow/culling.h"
#include "flow/segment_mover.h"
#include "knead/flow.h"

namespace knead::detail {

// A segment, prepared for many groups.
struct ReadySegment {
  const Segment* segment = nullptr;
  Culling culling;
  SegmentMover move;
  // Moves points from the segment's beginning to t = 0, where the limit cylinder chooses them; null if they are there.
  std::unique_ptr<const Segment> to_start;
  SegmentMover move_to_start;

  ReadySegment(const Segment& of, const AdvectOptions& options);
};

// A flow that moves points several times: its segments are prepared by the first use, and kept if they are few.
class ReadyFlow {
 public:
  // The flow must outlive it. Throws InvalidInput where validate(flow) does.
  ReadyFlow(const Flow& flow, const AdvectOptions& options);

  const Flow& flow() const { return flow_; }
  const AdvectOptions& options() const { return options_; }

  // Calls body with prepared segments that follow each other, until it returns false.
  template <class Body>
  void in_batches(const Body& body);

 private:
  const Flow& flow_;
  AdvectOptions options_;
  bool keeps_ = false;
  std::vector<ReadySegment> kept_;
};

class BlockMover {
 public:
  // `max_evaluations`: of v, for all path lines together.
  BlockMover(PointBlocks& blocks, std::span<const Vec3d> points, const AdvectOptions& options,
             std::uint64_t max_evaluations)
      : blocks_(blocks), points_(points), options_(options), max_evaluations_(max_evaluations) {}

  AdvectResult run(ReadyFlow& flow);

 private:
  struct Work;  // of one thread, for one group

  void run(const std::vector<ReadySegment>& segments);
  std::vector<std::size_t> groups_reached(const std::vector<ReadySegment>& segments) const;
  void move_group(const std::vector<ReadySegment>& segments, std::size_t group);
  void move_group(const ReadySegment& segment, Work& work);
  static bool ask(const void* mover, std::uint64_t evaluations) {
    return static_cast<const BlockMover*>(mover)->is_stopped(evaluations);
  }
  static Surround ball_of(const PointBlocks::Bounds& bounds);
  bool is_missed(const ReadySegment& segment, std::size_t block);
  bool is_between(const ReadySegment& segment, std::size_t block);
  void choose_members(const ReadySegment& segment, Work& work) const;
  bool is_stopped(std::uint64_t evaluations = 0) const;

  PointBlocks& blocks_;
  std::span<const Vec3d> points_;
  const AdvectOptions& options_;
  std::uint64_t max_evaluations_;
  std::atomic<std::uint64_t> accepted_{0};
  std::atomic<std::uint64_t> rejected_{0};
  std::atomic<std::uint64_t> evaluations_{0};
  std::atomic<bool> complete_{true};
};

// Does the same as advect(), but ends with the status `step_limit`, and leaves the points unchanged, soon after all
// path lines together need more than `max_evaluations` of v. Whether they do depends on the points and the flow alone.
AdvectResult advect_within(ReadyFlow& flow, std::span<Vec3d> points, std::uint64_t max_evaluations);

}  // namespace knead::detail
