// Private to polygonise: finds the cells of a regular grid that contain the surface {f = 0}.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "knead/mesh/polygonise.h"

namespace knead::polygonise_detail {

// A grid of cubic cells. Cell (x, y, z) has 0 <= x < cells[0] and so on; cell (0, 0, 0) begins at `origin`.
struct Grid {
  Vec3d origin;
  double cell = 0;
  std::array<std::uint32_t, 3> cells{};

  Vec3d at(double x, double y, double z) const { return origin + Vec3d{x, y, z} * cell; }
};

// Returns grid coordinates as one number that sorts by z, then y, then x; 20 bits each. grid_place() is the inverse.
inline std::uint64_t grid_key(std::uint64_t x, std::uint64_t y, std::uint64_t z) { return (z << 40) | (y << 20) | x; }
inline std::array<std::uint32_t, 3> grid_place(std::uint64_t key) {
  constexpr std::uint64_t kMask = (1U << 20) - 1;
  return {static_cast<std::uint32_t>(key & kMask), static_cast<std::uint32_t>((key >> 20) & kMask),
          static_cast<std::uint32_t>(key >> 40)};
}

// A cell with corners both inside and outside. Corner c has the offset (c & 1, (c >> 1) & 1, c >> 2).
struct SurfaceCell {
  std::uint64_t key = 0;
  std::array<double, 8> values{};

  bool inside(int corner) const { return values[corner] < 0; }
};

// Returns every such cell, by increasing key. For lipschitz see PolygoniseOptions.
std::vector<SurfaceCell> surface_cells(const ScalarFunction& f, const Grid& grid, double lipschitz);

}  // namespace knead::polygonise_detail
