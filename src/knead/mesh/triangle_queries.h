// One triangle and a point (private to this room).
#pragma once

#include <array>

#include "knead/math/vec3.h"

namespace knead {

struct NearTriangle {
  std::array<double, 3> barycentric{};
  Vec3d point;
  double distance2 = 0;
};

// The triangle's point nearest to p, for any triangle. Its distance is never below the true one by more than rounding;
// it exceeds it where rounding decides between the inside and a side.
NearTriangle nearest_on_triangle(const std::array<Vec3d, 3>& corners, const Vec3d& p);

}  // namespace knead
