// When a moving tool reaches a resting point.
#pragma once

#include <optional>

#include "knead/flow/segment.h"

namespace knead {

// The earliest time, from t towards segment.end, at which the point x, at rest, can be inside the support (r < outer)
// of a field of the segment; t itself if it is inside already; nothing if it never is. Exact for balls and capsules
// (the root of a quadratic); for other regions a lower bound, at most 1e-4 (outer - inner) of the tool's way too early.
std::optional<double> next_contact(const Segment& segment, const Vec3d& x, double t);

}  // namespace knead
