// An axis-aligned box.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "knead/math/vec3.h"

namespace knead {

struct Box {
  Vec3d min{kInfinity, kInfinity, kInfinity};
  Vec3d max{-kInfinity, -kInfinity, -kInfinity};

  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  bool empty() const { return !(min.x <= max.x); }
  Vec3d center() const { return (min + max) * 0.5; }
  double diagonal() const { return empty() ? 0.0 : norm(max - min); }

  void extend(const Vec3d& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
};

// The smallest box that holds every point; empty for no points.
inline Box bounding_box(std::span<const Vec3d> points) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  return box;
}

}  // namespace knead
