// The scaled Jacobians of cells as functions of the place of one vertex.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cells/cells.h"
#include "knead/remesh.h"
#include "knead/vec.h"

namespace knead::remesh_detail {

// A value and how it grows with the place.
struct LinearApproximation {
  double value = 0;
  Vec3d gradient;
};

// A tetrahedron: the least of its four corners.
class SeenTetrahedron {
 public:
  // others: right-handed from the vertex. factor: what the least Jacobian of the corners is multiplied with.
  SeenTetrahedron(const std::array<Vec3d, 3>& others, double factor);

  double quality(const Vec3d& place) const;
  LinearApproximation linear(const Vec3d& place) const;

 private:
  struct There;

  std::array<Vec3d, 3> others_;
  Vec3d across_;                      // vector product of two edges of the opposite face
  std::array<double, 3> opposite_{};  // for each corner of that face the product of the squares of its two edges in it
  double factor_;
};

// One corner of another cell: the vertex itself, or a neighbour of it.
class SeenCorner {
 public:
  // The vertex has right-handed edges to the others.
  static SeenCorner of_vertex(const std::array<Vec3d, 3>& others, double factor) { return {true, others, factor}; }
  // The edges from the origin to the vertex, to `next` and to `last` are right-handed.
  static SeenCorner beside(const Vec3d& origin, const Vec3d& next, const Vec3d& last, double factor);

  double quality(const Vec3d& place) const { return linear(place).value; }
  LinearApproximation linear(const Vec3d& place) const;

 private:
  SeenCorner(bool is_vertex, const std::array<Vec3d, 3>& points, double factor)
      : is_vertex_(is_vertex), points_(points), factor_(factor) {}

  bool is_vertex_;
  std::array<Vec3d, 3> points_;  // of a neighbour: its place, and the vector product of the directions of two edges
  double factor_;
};

// Interior vertices of a volume mesh move until the worst cells around them are good enough.

// The work on one mesh.
class FreeVertices {
 public:
  // whole: the points after the whole motion. Vertices that it leaves at rest are not free. All must outlive this.
  FreeVertices(const CellBaseline& judged, std::span<const Vec3d> whole, const CellOptions& options);

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

  const CellBaseline& judged_;
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
