// Volumes and ray hits of a surface whose points are in a GPU's memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "knead/gpu/gpu.h"

namespace knead::gpu {

// The first triangle that a ray hits.
struct GpuHit {
  std::uint32_t triangle = 0;
  double t = 0;                    // at origin + t direction
  std::array<Vec3d, 3> corners{};  // as they are on the GPU
  // The smallest t at which the ray leaves the shape, on the side of a triangle's normal; t itself if the ray began
  // inside. Empty if it does not leave.
  std::optional<double> leaves_at{};
};

// Triangles in a GPU's memory. Their indices refer to the points given to each call. Must not outlive its Gpu.
//
// Every function throws GpuError if the GPU fails or if the points fill more than four buffers, and InvalidInput if a
// triangle refers to a point that does not exist.
class GpuSurface {
 public:
  GpuSurface(Gpu& gpu, std::span<const std::array<std::uint32_t, 3>> triangles);
  ~GpuSurface();
  GpuSurface(const GpuSurface&) = delete;
  GpuSurface& operator=(const GpuSurface&) = delete;
  GpuSurface(GpuSurface&&) noexcept;
  GpuSurface& operator=(GpuSurface&&) noexcept;

  // Returns the signed volume: a sixth of the sum of (a - origin) . ((b - origin) x (c - origin)), positive if
  // triangles are counter-clockwise seen from outside. For a closed surface the origin matters only for rounding, which
  // is smallest if the origin is near. The sum is in double, and its order depends only on the number of triangles: one
  // GPU and driver always return the same bits. Reads 8 bytes.
  double volume(const GpuPoints& points, const Vec3d& origin) const;

  // Returns the first triangle that the ray hits at t >= 0, of several at the same t the one with the lowest number;
  // empty if there is none. The direction is not zero; it need not be a unit vector. The GPU selects the triangles that
  // the ray may hit, and the CPU decides among them with the formulas and exact signs of SurfaceTree
  // (mesh/surface_tree.h); so both return the same to the bit. Time: linear in the number of triangles. Reads about
  // 1 KB, and a second time if the ray may hit more than 16 triangles.
  std::optional<GpuHit> first_hit(const GpuPoints& points, const Vec3d& origin, const Vec3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knead::gpu
