// An axis-aligned box.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "knead/math/vec3.h"

namespace knead {

// The points p with min <= p <= max in every coordinate. A new box is empty: min is above max.
struct Box {
  Vec3d min{kInfinity, kInfinity, kInfinity};
  Vec3d max{-kInfinity, -kInfinity, -kInfinity};

  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  // Returns whether the box contains no point.
  bool empty() const { return !(min.x <= max.x); }
  // Returns the midpoint. The box must not be empty.
  Vec3d center() const { return (min + max) * 0.5; }
  // The length of the diagonal; 0 if the box is empty.
  double diagonal() const { return empty() ? 0.0 : norm(max - min); }

  // Grows the box until it contains p.
  void extend(const Vec3d& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
};

// Returns whether a point is in the box.
inline bool contains(const Box& box, const Vec3d& p) {
  return p.x >= box.min.x && p.y >= box.min.y && p.z >= box.min.z && p.x <= box.max.x && p.y <= box.max.y &&
         p.z <= box.max.z;
}

// Returns the smallest box that contains every point; empty if there are no points.
inline Box bounding_box(std::span<const Vec3d> points) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  return box;
}

}  // namespace knead
