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

// A cell with corners at one place, as solvers write wedges, pyramids and tetrahedra as hexahedra: the corners of the
// cell that is meant which have three neighbours. They decide about it as those of other cells do.
struct CollapsedCell {
  std::array<CellCorner, 8> corners{};
  std::size_t count = 0;
  double regular = 1;           // as in CellShape
  bool is_tetrahedron = false;  // of which the first corner names all four
};

// Returns true if two neighbouring corners are at one place.
bool is_collapsed(const CellShape& shape, std::span<const Vec3d> corners);

// Returns the cell that is meant.
CollapsedCell collapsed_cell(const CellShape& shape, std::span<const Vec3d> corners);

// Returns the least scaled Jacobian of the corners, as cell_quality() does.
double scaled_jacobian(const CellShape& shape, std::span<const Vec3d> corners);

}  // namespace knead
