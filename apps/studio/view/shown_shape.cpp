#include "view/shown_shape.h"

namespace knead::studio {

bool ShownShape::follow(const ShapeState& state, const PendingStrokes* pending, double diagonal,
                        render::LiveView& view) {
  return gpu_ ? gpu_->follow(state, pending, diagonal, view) : send(state, view);
}

void ShownShape::use_cpu() {
  gpu_.reset();
  state_ = {};
}

bool ShownShape::send(const ShapeState& state, render::LiveView& view) {
  if (state.mesh == nullptr) return false;
  if (state.mesh != state_.mesh || state.positions.size() != positions_.size()) {
    const Mesh mesh = state.to_mesh();
    view.set_shape(mesh);
    positions_ = mesh.positions;
    state_ = state;
    touched_ = positions_.size();
    return true;
  }
  const std::vector<IndexRange> changes = state.positions.changes_since(state_.positions);
  if (changes.empty()) return false;
  std::vector<render::VertexRange> ranges;
  touched_ = 0;
  for (const IndexRange& range : changes) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      if (!(positions_[i] == state.positions[i])) ++touched_;
      positions_[i] = state.positions[i];
    }
    ranges.push_back({range.begin, range.end});
  }
  view.move(positions_, ranges);
  state_ = state;
  return true;
}

}  // namespace knead::studio
