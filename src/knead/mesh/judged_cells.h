// The cells of a volume mesh before a deformation, judged once for many deformations. Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/math/progress.h"
#include "knead/mesh/measures.h"

namespace knead {

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
class JudgedCells {
 public:
  // Throws as cell_quality(), with the cell's number for a corner that is no point; Cancelled.
  JudgedCells(const Cells& cells, std::span<const Vec3d> before, int threads, const Progress* progress);

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
