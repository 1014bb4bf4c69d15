// Keeps the shape on the graphics card the one that Studio shows.
#pragma once

#include <vector>

#include "knead/render/live_view.h"
#include "knead/session/workbench.h"

namespace knead::studio {

class DrawnShape {
 public:
  // Sends what has changed since the last call. Returns whether anything has.
  bool follow(const ShapeState& state, render::LiveView& view);

  // The vertices that were elsewhere before the last call that returned true.
  std::size_t touched() const { return touched_; }

 private:
  std::shared_ptr<const Mesh> mesh_;
  Snapshot positions_;
  std::vector<Vec3d> flat_;
  std::size_t touched_ = 0;
};

}  // namespace knead::studio
