// The cells around one vertex of a volume mesh: their scaled Jacobians as functions of its position, and the search for
// a better position.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cells/cells.h"
#include "knead/vec.h"

namespace knead::detail {

// A value at a position, and its gradient there.
struct LinearApproximation {
  double value = 0;
  Vec3d gradient;
};

// A tetrahedron, judged by the least of its four corners.
class SeenTetrahedron {
 public:
  // others: right-handed from the vertex. factor: scales the least Jacobian of the corners.
  SeenTetrahedron(const std::array<Vec3d, 3>& others, double factor);

  double quality(const Vec3d& position) const;
  LinearApproximation linear(const Vec3d& position) const;

 private:
  struct Corners;

  std::array<Vec3d, 3> others_;
  Vec3d across_;                      // vector product of two edges of the opposite face
  std::array<double, 3> opposite_{};  // for each corner of that face: the product of its two squared edges in it
  double factor_;
};

// One corner of another kind of cell: the vertex itself, or a neighbour.
class SeenCorner {
 public:
  // The vertex has right-handed edges to the others.
  static SeenCorner of_vertex(const std::array<Vec3d, 3>& others, double factor) { return {true, others, factor}; }
  // The edges from the origin to the vertex, to `next` and to `last` are right-handed.
  static SeenCorner beside(const Vec3d& origin, const Vec3d& next, const Vec3d& last, double factor);

  double quality(const Vec3d& position) const { return linear(position).value; }
  LinearApproximation linear(const Vec3d& position) const;

 private:
  SeenCorner(bool is_vertex, const std::array<Vec3d, 3>& points, double factor)
      : is_vertex_(is_vertex), points_(points), factor_(factor) {}

  bool is_vertex_;
  std::array<Vec3d, 3> points_;  // of a neighbour: its position, and the cross product of two unit edges
  double factor_;
};

// Returns the step d for which the least of value + gradient . d, less |d|^2 / (2 reach), is greatest; 0 if no value
// can rise. There is at least one value, and as many gradients.
//
// Method: in the dual problem, the step is a weighted sum of the gradients. At most four weights are above 0; an active
// set finds them: P. Wolfe, "Finding the nearest point in a polytope", Mathematical Programming 11, 1976.
Vec3d best_step(std::span<const double> values, std::span<const Vec3d> gradients, double reach);

// The cells around a vertex. Quality is the scaled Jacobian, negated for a cell that was inside out before. One object
// serves many vertices.
class VertexStar {
 public:
  // Reads the cells around the vertex. Cells that were flat or mixed before do not count.
  void read(const CellBaseline& judged, const CellStars& stars, std::span<const Vec3d> points, std::uint32_t vertex);

  Vec3d position() const { return start_ + position_ * size_; }

  // Moves the vertex until the least quality is `goal`, or grows no more. The least quality never falls.
  void raise(double goal);

 private:
  void add(const CellBaseline& judged, std::uint32_t number, std::span<const Vec3d> points, std::uint32_t vertex);
  double least_at(const Vec3d& position) const;
  void linearise();
  bool climb(double reach, double goal);  // returns true if the least quality grew

  // Relative to `start_`, in units of `size_`.
  std::vector<SeenTetrahedron> tetrahedra_;
  std::vector<SeenCorner> corners_;
  std::vector<double> values_;
  std::vector<Vec3d> gradients_;
  Vec3d start_;
  Vec3d position_;   // in these units, too
  double size_ = 0;  // the longest edge
  double least_ = kInfinity;
};

}  // namespace knead::detail
