#include "drawn_shape.h"

namespace knead::studio {

bool DrawnShape::follow(const ShapeState& state, render::LiveView& view) {
  if (state.mesh == nullptr) return false;
  if (state.mesh != mesh_ || state.positions.size() != flat_.size()) {
    const Mesh mesh = state.to_mesh();
    view.set_shape(mesh);
    flat_ = mesh.positions;
    mesh_ = state.mesh;
    positions_ = state.positions;
    touched_ = flat_.size();
    return true;
  }
  const std::vector<IndexRange> changes = state.positions.changes_since(positions_);
  if (changes.empty()) return false;
  std::vector<render::VertexRange> ranges;
  touched_ = 0;
  for (const IndexRange& range : changes) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      if (!(flat_[i] == state.positions[i])) ++touched_;
      flat_[i] = state.positions[i];
    }
    ranges.push_back({range.begin, range.end});
  }
  view.move(flat_, ranges);
  positions_ = state.positions;
  return true;
}

}  // namespace knead::studio
