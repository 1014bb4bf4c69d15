// The corners and faces of linear cells, in VTK's order.
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

// Which cells lie around each point of a volume mesh. Internal to the library.

// The cells around each point.
struct CellStars {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> cells;

  // Returns the cells that have this point as a corner, ascending.
  std::span<const std::uint32_t> of(std::uint32_t point) const {
    return std::span(cells).subspan(first[point], first[point + 1] - first[point]);
  }
};

// Returns the stars of cells whose corners are below `points`; below 2^32 cells.
CellStars stars_of(const Cells& cells, std::size_t points);

// Returns whether a face at the point belongs to one cell only, or to more than two.
bool is_on_boundary(const Cells& cells, const CellStars& stars, std::uint32_t point);

// The cells of a volume mesh before a deformation, judged once for many deformations. Internal to the library.

// A cell and its quality.
struct WorstCell {
  std::size_t cell = 0;
  double scaled_jacobian = 0;  // as in CellChanges
};

// A cell after a deformation; as in CellChanges.
struct CellNow {
  double volume_ratio = 1;
  double scaled_jacobian = 0;
  bool is_inverted = false;
};

// What the cells were before. Cells and points must outlive it.
class CellBaseline {
 public:
  // Throws as cell_quality(), with the cell's number for a corner that is no point; Cancelled.
  CellBaseline(const Cells& cells, std::span<const Vec3d> before, int threads, const Progress* progress);

  const Cells& cells() const { return cells_; }
  std::span<const Vec3d> before() const { return before_; }
  // Returns the orientation of a cell before: cell_quality()'s.
  int side(std::size_t cell) const { return sides_[cell]; }

  // Returns whether the deformation moves a corner of the cell.
  bool is_moved(std::size_t cell, std::span<const Vec3d> after) const;

  // Returns whether a quality is one that the bound forbids: the cell was not below it before, and is now. Of other
  // cells only inverted ones are.
  bool is_below(std::size_t cell, double scaled_jacobian, double bound) const {
    return sides_[cell] != 0 && scaled_jacobian < (jacobians_[cell] >= bound ? bound : 0);
  }

  // Returns what a deformation did to a cell.
  CellNow now(std::size_t cell, std::span<const Vec3d> after) const;

  // Returns the worst of the cells that a deformation spoils: that it inverts, or whose scaled Jacobian falls from the
  // bound or above to below it. A cell that was flat or mixed before is never spoiled. Of equally bad cells the first.
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
