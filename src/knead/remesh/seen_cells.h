// The scaled Jacobians of cells as functions of the place of one vertex. Internal to the remesh room.
#pragma once

#include <array>

#include "knead/math/vec3.h"

namespace knead::remesh_detail {

// A value and how it grows with the place.
struct Slant {
  double value = 0;
  Vec3d gradient;
};

// A tetrahedron: the least of its four corners.
class SeenTetrahedron {
 public:
  // others: right-handed from the vertex. factor: what the least Jacobian of the corners is multiplied with.
  SeenTetrahedron(const std::array<Vec3d, 3>& others, double factor);

  double quality(const Vec3d& place) const;
  Slant slant(const Vec3d& place) const;

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

  double quality(const Vec3d& place) const { return slant(place).value; }
  Slant slant(const Vec3d& place) const;

 private:
  SeenCorner(bool is_vertex, const std::array<Vec3d, 3>& points, double factor)
      : is_vertex_(is_vertex), points_(points), factor_(factor) {}

  bool is_vertex_;
  std::array<Vec3d, 3> points_;  // of a neighbour: its place, and the vector product of the directions of two edges
  double factor_;
};

}  // namespace knead::remesh_detail
