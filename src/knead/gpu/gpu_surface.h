// What is asked of a surface whose points lie in a GPU's memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "knead/gpu/gpu.h"

namespace knead::gpu {

// A triangle that a ray meets.
struct GpuHit {
  std::uint32_t triangle = 0;
  double t = 0;                    // at origin + t direction
  std::array<Vec3d, 3> corners{};  // as they lie on the GPU
  // Where the ray first leaves the shape, at the side of a triangle's normal: at t itself if it began inside. Nothing
  // where it does not.
  std::optional<double> leaves_at{};
};

// Triangles in a GPU's memory, to be asked about with points there, which they number. Must not outlive the GPU.
// Movable. All throw GpuError where the GPU fails, and where its driver has the points in more than four buffers;
// InvalidInput where a triangle has a point that is not there.
class GpuSurface {
 public:
  GpuSurface(Gpu& gpu, std::span<const std::array<std::uint32_t, 3>> triangles);
  ~GpuSurface();
  GpuSurface(const GpuSurface&) = delete;
  GpuSurface& operator=(const GpuSurface&) = delete;
  GpuSurface(GpuSurface&&) noexcept;
  GpuSurface& operator=(GpuSurface&&) noexcept;

  // The signed volume within: a sixth of the sum of (a - origin) . ((b - origin) x (c - origin)), positive where
  // triangles are counter-clockwise seen from outside. Of a closed surface it does not depend on the origin, but for
  // rounding, which is least where the origin is near. Summed in double in an order that depends on the number of
  // triangles alone: the same bits whenever it is asked on one GPU and driver. Reads 8 bytes.
  double volume(const GpuPoints& points, const Vec3d& origin) const;

  // The first triangle that the ray meets at t >= 0, of several at the same t the one of the lowest number; nothing
  // where it meets none. The direction is not zero; it need not be a unit vector. The GPU says which triangles the
  // ray may meet and the CPU decides among them, by the formulas and exact signs of SurfaceTree (mesh/surface_tree.h),
  // so with the same answer to the bit. Time: linear in the triangles. Reads about 1 KB, where the ray meets more than
  // 16 triangles twice.
  std::optional<GpuHit> first_hit(const GpuPoints& points, const Vec3d& origin, const Vec3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knead::gpu
