// Moving points with a bound on the work. Internal.
#pragma once

#include <cstdint>
#include <span>

#include "knead/flow/advect.h"

namespace knead::detail {

// Does as advect(), but ends with the status `step_limit`, and leaves the points as they were, if all path lines
// together need more than so many evaluations of v. Whether they do depends on the points and the flow alone; it ends
// soon after.
AdvectResult advect_within(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options,
                           std::uint64_t most_evaluations);

}  // namespace knead::detail
