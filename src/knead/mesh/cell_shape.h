// The corners and faces of linear cells, in VTK's order.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "knead/math/vec3.h"
#include "knead/mesh/measures.h"

namespace knead {

using CellCorner = std::array<std::uint8_t, 4>;  // and its three neighbours, which turn to the right-handed side
using CellFace = std::array<std::uint8_t, 4>;    // looks outward; a triangle has its first corner twice

struct CellShape {
  std::span<const CellCorner> corners;
  std::span<const CellFace> faces;
  double regular = 1;  // what the Jacobian of the cell with equal edges is multiplied with to be 1
};

// Returns the shape of cells of this kind.
const CellShape& shape_of(CellKind kind);

// Returns the least scaled Jacobian of the corners, as cell_quality() does.
double scaled_jacobian(const CellShape& shape, std::span<const Vec3d> corners);

}  // namespace knead
