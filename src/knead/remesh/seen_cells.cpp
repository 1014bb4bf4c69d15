#include "knead/remesh/seen_cells.h"

#include <cmath>
#include <cstddef>

namespace knead::remesh_detail {

// The determinant, and the squared product of the edges at the corner where the determinant over that product is least.
struct SeenTetrahedron::There {
  std::array<Vec3d, 3> to;  // the other corners
  std::array<double, 3> squares;
  double determinant;
  double product = 0;
  std::size_t worst = 0;  // the corner; 3: the vertex

  There(const SeenTetrahedron& seen, const Vec3d& place)
      : to{seen.others_[0] - place, seen.others_[1] - place, seen.others_[2] - place},
        squares{norm2(to[0]), norm2(to[1]), norm2(to[2])},
        determinant(dot(to[0], seen.across_)) {
    const std::array<double, 4> products{squares[0] * seen.opposite_[0], squares[1] * seen.opposite_[1],
                                         squares[2] * seen.opposite_[2], squares[0] * squares[1] * squares[2]};
    // The sign of the factor is in the vector `across`.
    for (std::size_t k = 1; k < 4; ++k) {
      if (determinant > 0 ? products[k] > products[worst] : products[k] < products[worst]) worst = k;
    }
    product = products[worst];
  }
};

SeenTetrahedron::SeenTetrahedron(const std::array<Vec3d, 3>& others, double factor)
    : others_(others),
      across_(cross(others[1] - others[0], others[2] - others[0]) * (factor < 0 ? -1 : 1)),
      factor_(std::abs(factor)) {
  const double first = norm2(others[1] - others[0]);
  const double second = norm2(others[2] - others[1]);
  const double third = norm2(others[0] - others[2]);
  opposite_ = {first * third, first * second, second * third};
}

double SeenTetrahedron::quality(const Vec3d& place) const {
  const There there(*this, place);
  return there.product > 0 ? factor_ * (there.determinant / std::sqrt(there.product)) : 0;
}

Slant SeenTetrahedron::slant(const Vec3d& place) const {
  const There there(*this, place);
  if (!(there.product > 0)) return {0, {0, 0, 0}};
  const double root = std::sqrt(there.product);
  Vec3d relative{0, 0, 0};  // how the product grows, relative to it
  for (std::size_t k = 0; k < 3; ++k) {
    if (there.worst == 3 || there.worst == k) relative -= there.to[k] / there.squares[k];
  }
  return {factor_ * (there.determinant / root), (across_ + relative * there.determinant) * (-factor_ / root)};
}

SeenCorner SeenCorner::beside(const Vec3d& origin, const Vec3d& next, const Vec3d& last, double factor) {
  const double lengths = norm(next - origin) * norm(last - origin);
  const Vec3d across = lengths > 0 ? cross(next - origin, last - origin) / lengths : Vec3d{0, 0, 0};
  return {false, {origin, across, {}}, factor};
}

Slant SeenCorner::slant(const Vec3d& place) const {
  if (!is_vertex_) {
    const Vec3d edge = place - points_[0];
    const double length = norm(edge);
    if (!(length > 0)) return {0, {0, 0, 0}};
    const double value = dot(edge, points_[1]) / length;
    return {factor_ * value, (points_[1] - edge * (value / length)) * (factor_ / length)};
  }
  const Vec3d a = points_[0] - place;
  const Vec3d b = points_[1] - place;
  const Vec3d c = points_[2] - place;
  const double lengths = norm(a) * norm(b) * norm(c);
  if (!(lengths > 0)) return {0, {0, 0, 0}};
  const Vec3d across = cross(a, b);
  const double value = dot(across, c) / lengths;
  const Vec3d growth = (across + cross(b, c) + cross(c, a)) / -lengths;
  return {factor_ * value, (growth + (a / norm2(a) + b / norm2(b) + c / norm2(c)) * value) * factor_};
}

}  // namespace knead::remesh_detail
