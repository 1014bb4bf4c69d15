// A surface that a stroke reads while it moves it.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "knead/mesh/triangulate.h"
#include "knead/tool/stroke.h"

namespace knead {

struct LiveSurface {
  std::span<const Vec3d> positions;             // as they are at the moment: apply moves them in place
  std::span<const Triangle> triangles;          // none: a point cloud
  std::function<std::vector<Vec3d>()> normals;  // of a point cloud's points, as they are at the moment; null: none
  std::function<bool(const Stroke&)> apply;     // moves the positions by a stroke that reads no surface; false: stop
};

}  // namespace knead
