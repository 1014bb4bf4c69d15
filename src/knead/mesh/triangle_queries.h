// The point of a triangle nearest to a given point (private to this room).
#pragma once

#include <array>

#include "knead/math/vec3.h"

namespace knead {

struct NearTriangle {
  std::array<double, 3> barycentric{};
  Vec3d point;
  double distance2 = 0;
};

// Returns the point of the triangle nearest to p, for any triangle. Its distance is below the true one by rounding
// errors at most. It may be above the true one if rounding decides between the interior and an edge.
NearTriangle nearest_on_triangle(const std::array<Vec3d, 3>& corners, const Vec3d& p);

}  // namespace knead
