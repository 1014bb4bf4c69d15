#include "knead/session/moved_shape.h"

namespace knead::session_detail {

namespace {

AdvectResult move_points(const Flow& flow, const AdvectOptions& options, std::vector<Vec3d>& points,
                         std::optional<PointBlocks>& blocks) {
  if (!blocks) blocks.emplace(points);
  const AdvectResult result = advect(flow, *blocks, options);
  blocks->update(points);
  return result;
}

// By a backend, which knows of no blocks: those that there are would be out of date.
AdvectResult move_vertices(const Flow& flow, const MoveOptions& options, MovedShape& shape) {
  if (!options.backend) return move_points(flow, options.vertices, shape.positions, shape.blocks);
  shape.earlier_steps = steps_of(shape);
  shape.blocks.reset();
  AdvectOptions counted = options.vertices;
  counted.steps = shape.earlier_steps;
  return options.backend(flow, shape.positions, counted);
}

}  // namespace

std::vector<std::uint32_t> steps_of(const MovedShape& shape) {
  std::vector<std::uint32_t> steps = shape.blocks ? shape.blocks->steps() : std::vector<std::uint32_t>{};
  steps.resize(shape.positions.size());
  for (std::size_t i = 0; i < shape.earlier_steps.size(); ++i) steps[i] += shape.earlier_steps[i];
  return steps;
}

void forget_blocks(MovedShape& shape) {
  shape.earlier_steps = steps_of(shape);
  shape.blocks.reset();
  shape.companion_blocks.reset();
}

void move(const Flow& flow, const MoveOptions& options, MovedShape& shape) {
  if (flow.segments.empty()) return;
  shape.counts += move_vertices(flow, options, shape);
  if (shape.counts.status != AdvectStatus::done || shape.companions.empty()) return;
  shape.counts.status = move_points(flow, options.companions, shape.companions, shape.companion_blocks).status;
}

}  // namespace knead::session_detail
