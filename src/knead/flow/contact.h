// When a moving tool reaches a resting point.
#pragma once

#include <optional>

#include "knead/flow/segment.h"

namespace knead {

// Returns the earliest time, from t towards segment.end, at which the resting point x can be inside the support
// (r < outer) of a field of the segment; t if it is inside already; nothing if it never is. Exact for balls and
// capsules (the root of a quadratic). For other regions a lower bound: the tool then still has at most 1e-4 (outer -
// inner) to move.
std::optional<double> next_contact(const Segment& segment, const Vec3d& x, double t);

}  // namespace knead
