// Stands in for compute shaders and the offline renderer, which pages do not have: both throw.
#include "knead/editor/gl.h"
#include "render/live/live.h"

namespace knead::render {

LiveCompute::LiveCompute(const LiveMesh&) { throw GpuError("this build has no compute shaders; use the CPU"); }

// Never called, because the constructor throws.
void LiveCompute::move(std::span<const PointBuffer>, const Placement&, const LiveBuffers&) const {}

Image render(const Scene&, const Options&) {
  throw GpuError("a page draws no posters; use Studio on the desktop, or knead render");
}

}  // namespace knead::render
