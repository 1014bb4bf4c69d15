// The loops in which a plane cuts a shape.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {

// Triangles that the plane cuts one after the other, across the edges that it cuts. Not closed at a border.
struct SliceLoop {
  double extent = 0;           // the greatest distance from the plane's point
  bool around_point = false;   // whether the loop goes around that point
  std::uint32_t triangle = 0;  // one of its triangles
};

// Returns the loops in the plane through the point across the normal. Time: linear, and a sort of the edges that are
// cut.
std::vector<SliceLoop> slice(const Vec3d& point, const Vec3d& normal, std::span<const Vec3d> positions,
                             std::span<const Triangle> triangles);

// Returns the innermost loop around the point, if there is one.
std::optional<SliceLoop> innermost(const std::vector<SliceLoop>& loops);

}  // namespace knead::detail
