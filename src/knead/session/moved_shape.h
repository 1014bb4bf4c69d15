// A shape's vertices on their way through flows, with the companions of its normals. Internal to the session room.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/flow/backend.h"

namespace knead::session_detail {

struct MovedShape {
  std::vector<Vec3d> positions;
  std::vector<Vec3d> companions;  // NormalCompanions::points
  AdvectResult counts;            // of the vertices; the status also of the companions
  // The same points laid out for moving, from the first move on; and the steps taken before, empty for none.
  std::optional<PointBlocks> blocks{};
  std::optional<PointBlocks> companion_blocks{};
  std::vector<std::uint32_t> earlier_steps{};
};

// The accepted steps of each vertex.
std::vector<std::uint32_t> steps_of(const MovedShape& shape);

// To be called where positions or companions are changed otherwise than by move.
void forget_blocks(MovedShape& shape);

struct MoveOptions {
  AdvectOptions vertices;  // steps is not looked at
  AdvectOptions companions;
  Backend backend{};  // moves the vertices; empty: advect
};

void move(const Flow& flow, const MoveOptions& options, MovedShape& shape);

}  // namespace knead::session_detail
