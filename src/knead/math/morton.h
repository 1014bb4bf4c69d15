// The order of points along a space-filling curve: points that are close in space are mostly close in this order.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "knead/math/box.h"
#include "knead/math/vec3.h"

namespace knead {

// Maps the points of a box to coordinates from -1 to 1, with the same scale along all axes. The box must not be empty.
// Rounding never reverses the order of two coordinates, so boxes that overlap still overlap after the mapping.
class ToUnit {
 public:
  explicit ToUnit(const Box& box) : center_(box.center()) {
    const Vec3d half = (box.max - box.min) * 0.5;
    const double largest = std::max({half.x, half.y, half.z});
    if (largest > 0) scale_ = 1 / largest;
  }

  std::array<float, 3> operator()(const Vec3d& p) const {
    const Vec3d q = (p - center_) * scale_;
    return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }

 private:
  Vec3d center_;
  double scale_ = 1;
};

// Returns the position on the Morton curve of a point with coordinates from -1 to 1 (21 bits for each coordinate).
std::uint64_t morton_code(const std::array<float, 3>& point);

}  // namespace knead
