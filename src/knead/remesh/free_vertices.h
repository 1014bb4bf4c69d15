// Interior vertices of a volume mesh move until the worst cells around them are good enough. Internal to the remesh
// room.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/cell_stars.h"
#include "knead/mesh/judged_cells.h"
#include "knead/remesh/remesh.h"

namespace knead::remesh_detail {

// The work on one mesh.
class FreeVertices {
 public:
  // whole: the points after the whole motion. Vertices that it leaves at rest are not free. All must outlive this.
  FreeVertices(const JudgedCells& judged, std::span<const Vec3d> whole, const CellOptions& options);

  // Moves free vertices around bad cells; marks them in `moved`. Gives up if a cell is still inverted after `patience`
  // rounds. The same bits for every number of threads.
  void improve(std::span<Vec3d> points, std::vector<std::uint8_t>& moved, int patience);

 private:
  double quality_of(std::size_t cell, std::span<const Vec3d> points) const;
  void fix_collapsed(std::uint32_t cell);
  void measure(std::span<const Vec3d> points);
  void find_freedom(std::uint32_t vertex);
  std::vector<std::uint32_t> free_corners(const std::vector<std::uint32_t>& cells, int rings);
  std::vector<std::vector<std::uint32_t>> apart(const std::vector<std::uint32_t>& vertices);
  void sweep(const std::vector<std::uint32_t>& bad, int rings, std::span<Vec3d> points,
             std::vector<std::uint8_t>& moved);

  const JudgedCells& judged_;
  const CellOptions& options_;
  std::vector<std::uint32_t> active_;  // the cells that the whole motion moves
  CellStars stars_;                    // of these cells
  std::vector<double> qualities_;      // of all cells; kept up only for active ones
  std::vector<std::uint8_t> freedom_;  // of each vertex: 0, 1 or not known yet
  std::vector<std::uint8_t> colors_;
  std::vector<std::uint8_t> vertex_marks_;  // 0, but for a moment
  std::vector<std::uint8_t> cell_marks_;
};

}  // namespace knead::remesh_detail
