// The cells around one vertex of a volume mesh, and the search for a better place of it. Internal to the remesh room.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "knead/mesh/cell_shape.h"
#include "knead/mesh/cell_stars.h"
#include "knead/mesh/judged_cells.h"

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
  // A cell as the vertex sees it.
  struct Around {
    const CellShape* shape = nullptr;
    std::array<Vec3d, 8> corners;  // of a tetrahedron: the other three, so that they are right-handed from the vertex
    std::size_t count = 0;
    std::size_t at = 0;  // the vertex among the corners
    double side = 1;
    // Of a tetrahedron: side times the vector product of two edges of the opposite face, and for each corner of that
    // face the product of the squares of its two edges in it.
    Vec3d across;
    std::array<double, 3> opposite{};

    bool is_tetrahedron() const { return count == 4; }
  };

  static double quality(Around& cell, const Vec3d& place);
  static Vec3d gradient(Around& cell, const Vec3d& place);
  static void look_from_vertex(Around& cell);
  double least_at(const Vec3d& place);
  void look_around();
  bool climb(double reach, double goal);  // returns whether that gained something

  std::vector<Around> cells_;  // seen from `start_`, in units of `size_`
  std::vector<double> qualities_;
  std::vector<Vec3d> gradients_;
  Vec3d start_;
  Vec3d place_;      // likewise
  double size_ = 0;  // the longest edge
  double least_ = std::numeric_limits<double>::infinity();
};

}  // namespace knead::remesh_detail
