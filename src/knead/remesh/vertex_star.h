// The cells around one vertex of a volume mesh, and the search for a better place of it. Internal to the remesh room.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "knead/mesh/cell_stars.h"
#include "knead/mesh/judged_cells.h"
#include "knead/remesh/seen_cells.h"

namespace knead::remesh_detail {

// Quality is the scaled Jacobian, its negative for a cell that was inside out before. One object serves many vertices.
class VertexStar {
 public:
  // Cells that were flat or mixed before do not count.
  void read(const JudgedCells& judged, const CellStars& stars, std::span<const Vec3d> points, std::uint32_t vertex);

  Vec3d place() const { return start_ + place_ * size_; }

  // Moves the vertex until the least quality is `goal`, or grows no more. It never falls.
  void raise(double goal);

 private:
  void add(const JudgedCells& judged, std::uint32_t number, std::span<const Vec3d> points, std::uint32_t vertex);
  double least_at(const Vec3d& place) const;
  void look_around();
  bool climb(double reach, double goal);  // returns whether that gained something

  // Seen from `start_`, in units of `size_`.
  std::vector<SeenTetrahedron> tetrahedra_;
  std::vector<SeenCorner> corners_;
  std::vector<double> values_;
  std::vector<Vec3d> gradients_;
  Vec3d start_;
  Vec3d place_;      // likewise
  double size_ = 0;  // the longest edge
  double least_ = std::numeric_limits<double>::infinity();
};

}  // namespace knead::remesh_detail
