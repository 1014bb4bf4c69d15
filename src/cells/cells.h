// The corners and faces of linear cells in VTK's order, the cells around points, and cells before a deformation.
// Internal to the library.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

inline constexpr std::size_t kCellGrain = 1024;  // cells or points that a thread takes at a time

using CellCorner = std::array<std::uint8_t, 4>;  // a corner and its three neighbours, which are right-handed
using CellFace = std::array<std::uint8_t, 4>;    // looks outward; a triangle has its first corner twice

// The corners with their neighbours, and the faces, of one kind of cell.
struct CellShape {
  std::span<const CellCorner> corners;
  std::span<const CellFace> faces;
  double regular = 1;  // scales the Jacobian of the cell with equal edges to 1
};

// Returns the shape of cells of this kind.
const CellShape& shape_of(CellKind kind);

// A cell with corners at the same position: some solvers write wedges, pyramids and tetrahedra as hexahedra. It is
// judged by those corners of the actual cell that have three neighbours.
struct CollapsedCell {
  std::array<CellCorner, 8> corners{};
  std::size_t count = 0;
  double regular = 1;           // as in CellShape
  bool is_tetrahedron = false;  // the first corner then names all four
};

// Returns true if two neighbouring corners are at the same position.
bool is_collapsed(const CellShape& shape, std::span<const Vec3d> corners);

// Returns the actual cell.
CollapsedCell collapsed_cell(const CellShape& shape, std::span<const Vec3d> corners);

// Returns the positions of the corners of a cell, which it copies to `corners`. Throws InvalidInput with the cell's
// number for a corner that is no point.
std::span<const Vec3d> corner_positions(const Cells& cells, std::size_t cell, std::span<const Vec3d> points,
                                        std::array<Vec3d, 8>& corners);

// Returns the least scaled Jacobian of the corners, as cell_quality() does.
double scaled_jacobian(const CellShape& shape, std::span<const Vec3d> corners);

// The cells around each point of a volume mesh.
struct CellStars {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> cells;

  // Returns the cells that have this point as a corner, ascending.
  std::span<const std::uint32_t> of(std::uint32_t point) const {
    return std::span(cells).subspan(first[point], first[point + 1] - first[point]);
  }
};

// Returns the stars of the points with these cells only, whose numbers ascend. Their corners are below `points`.
CellStars stars_of(const Cells& cells, std::span<const std::uint32_t> numbers, std::size_t points);

// Returns true if a face at the point belongs to one cell only, or to more than two.
bool is_on_boundary(const Cells& cells, const CellStars& stars, std::uint32_t point);

// The worst cell after a deformation.
struct WorstCell {
  std::size_t cell = 0;
  double scaled_jacobian = 0;  // as in CellChanges
};

// A cell after a deformation, with the values of CellChanges.
struct DeformedCell {
  double volume_ratio = 1;
  double scaled_jacobian = 0;
  bool is_inverted = false;
};

// The cells of a volume mesh before a deformation, measured once for many deformations. Cells and points must outlive
// it.
class CellBaseline {
 public:
  // Throws as cell_quality(), with the cell's number for a corner that is no point; Cancelled.
  CellBaseline(const Cells& cells, std::span<const Vec3d> before, int threads, const Progress* progress);

  const Cells& cells() const { return cells_; }
  std::span<const Vec3d> before() const { return before_; }
  // Returns the orientation of a cell before: cell_quality()'s.
  int side(std::size_t cell) const { return sides_[cell]; }

  // Returns true if the deformation moves a corner of the cell.
  bool is_moved(std::size_t cell, std::span<const Vec3d> after) const;

  // Returns true if the quality of a cell is not allowed: below the bound; or below 0 if the cell was below the bound
  // before.
  bool is_below(std::size_t cell, double scaled_jacobian, double bound) const {
    return sides_[cell] != 0 && scaled_jacobian < (jacobians_[cell] >= bound ? bound : 0);
  }

  // Returns the cell after a deformation.
  DeformedCell now(std::size_t cell, std::span<const Vec3d> after) const;

  // Returns the worst cell that a deformation spoils: it is inverted, or its scaled Jacobian falls from the bound or
  // above to below it. Cells that were flat or mixed before are never spoiled. Of equally bad cells, returns the first.
  std::optional<WorstCell> worst_spoiled(std::span<const Vec3d> after, double bound) const;

 private:
  const Cells& cells_;
  std::span<const Vec3d> before_;
  int threads_;
  const Progress* progress_;
  std::vector<std::int8_t> sides_;
  std::vector<double> jacobians_;
  std::vector<double> volumes_;
};

}  // namespace knead
