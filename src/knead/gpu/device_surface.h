// What is asked of a surface whose points lie in a graphics card's memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "knead/gpu/device.h"

namespace knead::gpu {

// A triangle that a ray meets.
struct DeviceHit {
  std::uint32_t triangle = 0;
  double t = 0;                    // at origin + t direction
  std::array<Vec3d, 3> corners{};  // as they lie on the device
  // Where the ray first leaves the shape, at the side of a triangle's normal: at t itself if it began inside. Nothing
  // where it does not.
  std::optional<double> leaves_at{};
};

// Triangles in a device's memory, to be asked about with points there, which they number. Must not outlive the device.
// Movable. All throw DeviceError where the device fails, and where its driver has the points in more than four buffers;
// InvalidInput where a triangle has a point that is not there.
class DeviceSurface {
 public:
  DeviceSurface(Device& device, std::span<const std::array<std::uint32_t, 3>> triangles);
  ~DeviceSurface();
  DeviceSurface(const DeviceSurface&) = delete;
  DeviceSurface& operator=(const DeviceSurface&) = delete;
  DeviceSurface(DeviceSurface&&) noexcept;
  DeviceSurface& operator=(DeviceSurface&&) noexcept;

  // The signed volume within: a sixth of the sum of (a - origin) . ((b - origin) x (c - origin)), positive where
  // triangles are counter-clockwise seen from outside. Of a closed surface it does not depend on the origin, but for
  // rounding, which is least where the origin is near. Summed in double in an order that depends on the number of
  // triangles alone: the same bits whenever it is asked on one device and driver. Reads 8 bytes.
  double volume(const DevicePoints& points, const Vec3d& origin) const;

  // The first triangle that the ray meets at t >= 0, of several at the same t the one of the lowest number; nothing
  // where it meets none. The direction is not zero; it need not be a unit vector. The device says which triangles the
  // ray may meet and the CPU decides among them, by the formulas and exact signs of SurfaceTree (mesh/surface_tree.h),
  // so with the same answer to the bit. Time: linear in the triangles. Reads about 1 KB, where the ray meets more than
  // 16 triangles twice.
  std::optional<DeviceHit> first_hit(const DevicePoints& points, const Vec3d& origin, const Vec3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knead::gpu
