// A surface that a stroke reads and moves at the same time.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "knead/mesh/triangulate.h"
#include "knead/tool/stroke.h"

namespace knead {

// The current positions and triangles of a shape, and how to move them.
struct LiveSurface {
  std::span<const Vec3d> positions;             // the current ones: apply moves them in place
  std::span<const Triangle> triangles;          // empty: a point cloud
  std::function<std::vector<Vec3d>()> normals;  // returns the current normals of a point cloud; null: there are none
  std::function<bool(const Stroke&)> apply;     // applies a stroke that reads no surface; false: stop
};

}  // namespace knead
