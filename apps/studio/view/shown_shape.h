// The shape that the live view shows: sent from the CPU, or moved on the GPU.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "knead/render.h"
#include "view/gpu_preview.h"

namespace knead::studio {

class ShownShape {
 public:
  // Gives the view what it shows: from the CPU only what has changed. The arguments are those of GpuPreview::follow;
  // the CPU shows `state`. Returns whether anything has changed since the last call. Throws as GpuPreview.
  bool follow(const ShapeState& state, const PendingStrokes* pending, double diagonal, render::LiveView& view);

  // Throws as GpuPreview; the CPU then remains in use.
  void use_gpu(const gpu::GpuOptions& options = {}) { gpu_.emplace(options); }
  void use_cpu();
  GpuPreview* gpu() { return gpu_ ? &*gpu_ : nullptr; }  // null: the CPU is in use
  const GpuPreview* gpu() const { return gpu_ ? &*gpu_ : nullptr; }

  // Returns how many vertices the last call of follow moved that returned true and used the CPU.
  std::size_t touched() const { return touched_; }

 private:
  bool send(const ShapeState& state, render::LiveView& view);

  std::optional<GpuPreview> gpu_;
  ShapeState state_;              // that was sent
  std::vector<Vec3d> positions_;  // the same
  std::size_t touched_ = 0;
};

}  // namespace knead::studio
