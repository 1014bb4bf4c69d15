// A surface that a stroke reads and moves at the same time.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "knead/math/progress.h"
#include "knead/mesh/triangulate.h"
#include "knead/tool/stroke.h"

namespace knead {

// The current positions and triangles of a shape, and how to move them.
struct LiveSurface {
  std::span<const Vec3d> positions;     // the current ones: apply moves them in place
  std::span<const Triangle> triangles;  // empty: a point cloud
  // Returns the current normal of a point of a cloud; null: there are none.
  std::function<Vec3d(std::uint32_t)> normal;
  std::function<bool(const Stroke&)> apply;  // applies a stroke that reads no surface; false: stop
  Progress* progress = nullptr;              // of long work between two calls of apply: says when to stop
};

// Throws InvalidInput, with the key in quotes, unless the vertex is one of the shape's.
void require_vertex(std::string_view key, std::span<const Vec3d> positions, std::uint32_t vertex);

}  // namespace knead
