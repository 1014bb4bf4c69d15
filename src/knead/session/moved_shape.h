// A shape's vertices on their way through flows, with the companions of its normals. Internal to the session room.
#pragma once

#include <cstdint>
#include <vector>

#include "knead/flow/advect.h"

namespace knead::session_detail {

struct MovedShape {
  std::vector<Vec3d> positions;
  std::vector<Vec3d> companions;     // NormalCompanions::points
  std::vector<std::uint32_t> steps;  // accepted steps of each vertex; empty: not counted
  AdvectResult counts;               // of the vertices; the status also of the companions
};

struct MoveOptions {
  AdvectOptions vertices;  // steps is not looked at
  AdvectOptions companions;
};

void move(const Flow& flow, const MoveOptions& options, MovedShape& shape);

}  // namespace knead::session_detail
