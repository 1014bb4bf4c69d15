#include "knead/session/moved_shape.h"

namespace knead::session_detail {

void move(const Flow& flow, const MoveOptions& options, MovedShape& shape) {
  if (flow.segments.empty()) return;
  AdvectOptions vertices = options.vertices;
  vertices.steps = shape.steps;
  shape.counts += advect(flow, shape.positions, vertices);
  if (shape.counts.status != AdvectStatus::done || shape.companions.empty()) return;
  shape.counts.status = advect(flow, shape.companions, options.companions).status;
}

}  // namespace knead::session_detail
