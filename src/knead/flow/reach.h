// Where a flow may move points.
#pragma once

#include <memory>

#include "knead/flow/segment.h"

namespace knead {

// Answers which balls of space a flow may move; keeps a copy of the flow. A question costs a distance for each field of
// each segment.
class FlowReach {
 public:
  explicit FlowReach(const Flow& flow);
  FlowReach(const FlowReach&) = delete;
  FlowReach& operator=(const FlowReach&) = delete;
  ~FlowReach();
  FlowReach(FlowReach&&) noexcept;
  FlowReach& operator=(FlowReach&&) noexcept;

  // Returns false only if every point of the ball keeps its bits; radius >= 0. Returns true for some balls that a tool
  // narrowly misses.
  bool may_move(const Vec3d& center, double radius) const;

  // Returns the size of the smallest part of a surface that the flow may move or bend: the least `outer` of balls,
  // capsules and point sets, and the least width of the intermediate regions of half-spaces. Infinity without these.
  double smallest_feature() const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace knead
