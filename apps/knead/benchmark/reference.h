// The paper's method in its plain form, for comparison: structures of doubles, one path line after the other on one
// core, v = grad p x grad q, RK4 with step doubling, no short cut for points that no tool reaches.
#pragma once

#include <cstdint>
#include <span>

#include "knead/flow.h"

namespace knead::bench {

struct ReferenceResult {
  std::uint64_t accepted_steps = 0;
  std::uint64_t evaluations = 0;
};

// Moves the points in place. `tolerance` is the length by which two half steps may differ from a whole one, over 15.
// No step lets the tool go further than a fifth of the intermediate region's width, so that it is not missed. For
// whole swept segments of one field, without a limit cylinder.
ReferenceResult advect_reference(const Flow& flow, std::span<Vec3d> points, double tolerance);

}  // namespace knead::bench
