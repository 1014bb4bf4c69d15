// Where a flow can move anything.
#pragma once

#include <memory>

#include "knead/flow/segment.h"

namespace knead {

// A copy of a flow, asked which balls it may touch. A question costs a distance for each field of each segment.
class FlowReach {
 public:
  explicit FlowReach(const Flow& flow);
  FlowReach(const FlowReach&) = delete;
  FlowReach& operator=(const FlowReach&) = delete;
  ~FlowReach();
  FlowReach(FlowReach&&) noexcept;
  FlowReach& operator=(FlowReach&&) noexcept;

  // False only where the flow leaves every point of the ball as it is, to the bit; radius >= 0. True may be said near a
  // tool that just misses.
  bool may_move(const Vec3d& center, double radius) const;

  // How small the part of a surface can be that the flow moves or bends: the least `outer` of balls, capsules and point
  // sets, and the least width of the transition of half-spaces. Infinity where there are none.
  double smallest_feature() const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

}  // namespace knead
