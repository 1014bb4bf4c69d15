#include "knead/remesh/vertex_star.h"

#include <algorithm>
#include <cmath>

namespace knead::remesh_detail {

namespace {

// Other vertices move later, too, and then this one again: so none is brought to its best place.
constexpr int kHalvings = 8;
constexpr double kLeastGain = 1e-3;
constexpr double kWideMargin = 0.1;  // cells whose quality is so much above the least count as worst, too

// A tetrahedron at one place of a corner: its determinant, and the squared product of the edges at the corner where the
// determinant over that product is least.
struct TetrahedronThere {
  std::array<Vec3d, 3> to;  // the other corners
  std::array<double, 3> squares;
  double determinant;
  double product = 0;
  std::size_t worst = 0;  // the corner; 3: the moving one

  TetrahedronThere(std::span<const Vec3d> others, const Vec3d& across, std::span<const double> opposite,
                   const Vec3d& place)
      : to{others[0] - place, others[1] - place, others[2] - place},
        squares{norm2(to[0]), norm2(to[1]), norm2(to[2])},
        determinant(dot(to[0], across)) {
    const std::array<double, 4> products{squares[0] * opposite[0], squares[1] * opposite[1], squares[2] * opposite[2],
                                         squares[0] * squares[1] * squares[2]};
    for (std::size_t k = 1; k < 4; ++k) {
      if (determinant > 0 ? products[k] > products[worst] : products[k] < products[worst]) worst = k;
    }
    product = products[worst];
  }

  double jacobian() const { return product > 0 ? determinant / std::sqrt(product) : 0; }

  // With the relative change of the product.
  Vec3d gradient(const Vec3d& across) const {
    if (!(product > 0)) return {0, 0, 0};
    Vec3d relative{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      if (worst == 3 || worst == k) relative -= to[k] / squares[k];
    }
    return (across + relative * determinant) * (-1 / std::sqrt(product));
  }
};

}  // namespace

void VertexStar::read(const JudgedCells& judged, const CellStars& stars, std::span<const Vec3d> points,
                      std::uint32_t vertex) {
  cells_.clear();
  start_ = points[vertex];
  place_ = {0, 0, 0};
  size_ = 0;
  for (const std::uint32_t number : stars.of(vertex)) {
    if (judged.side(number) == 0) continue;
    const std::span<const std::uint32_t> corners = judged.cells().corners_of(number);
    Around& cell = cells_.emplace_back();
    cell.shape = &shape_of(judged.cells().kinds[number]);
    cell.count = corners.size();
    cell.side = judged.side(number);
    cell.at = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), vertex) - corners.begin());
    for (std::size_t k = 0; k < cell.count; ++k) {
      cell.corners[k] = points[corners[k]] - start_;
      size_ = std::max(size_, norm(cell.corners[k]));
    }
  }
  if (!(size_ > 0)) return;
  for (Around& cell : cells_) {
    for (std::size_t k = 0; k < cell.count; ++k) cell.corners[k] *= 1 / size_;
    if (cell.is_tetrahedron()) look_from_vertex(cell);
  }
  least_ = -std::numeric_limits<double>::infinity();
  least_ = least_at(place_);
}

void VertexStar::look_from_vertex(Around& cell) {
  const CellCorner& corner = cell.shape->corners[cell.at];
  const std::array<Vec3d, 3> others{cell.corners[corner[1]], cell.corners[corner[2]], cell.corners[corner[3]]};
  std::copy(others.begin(), others.end(), cell.corners.begin());
  cell.across = cross(others[1] - others[0], others[2] - others[0]) * cell.side;
  const double first = norm2(others[1] - others[0]);
  const double second = norm2(others[2] - others[1]);
  const double third = norm2(others[0] - others[2]);
  cell.opposite = {first * third, first * second, second * third};
}

double VertexStar::quality(Around& cell, const Vec3d& place) {
  if (cell.is_tetrahedron()) {
    const TetrahedronThere there(cell.corners, cell.across, cell.opposite, place);
    return cell.shape->regular * there.jacobian();
  }
  cell.corners[cell.at] = place;
  return cell.side * scaled_jacobian(*cell.shape, std::span<const Vec3d>(cell.corners).first(cell.count));
}

Vec3d VertexStar::gradient(Around& cell, const Vec3d& place) {
  constexpr double h = 1e-6;
  if (cell.is_tetrahedron()) {
    const TetrahedronThere there(cell.corners, cell.across, cell.opposite, place);
    return there.gradient(cell.across) * cell.shape->regular;
  }
  Vec3d result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d up = place;
    Vec3d down = place;
    up[axis] += h;
    down[axis] -= h;
    result[axis] = (quality(cell, up) - quality(cell, down)) / (2 * h);
  }
  return result;
}

// Stops at the first cell that is worse than the least so far.
double VertexStar::least_at(const Vec3d& place) {
  double least = std::numeric_limits<double>::infinity();
  for (Around& cell : cells_) {
    least = std::min(least, quality(cell, place));
    if (least < least_) return least;
  }
  return least;
}

// Measures each cell, and of the worst ones how their quality grows with the vertex's place.
void VertexStar::look_around() {
  qualities_.resize(cells_.size());
  gradients_.resize(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    qualities_[i] = quality(cells_[i], place_);
    if (qualities_[i] <= least_ + kWideMargin) gradients_[i] = gradient(cells_[i], place_);
  }
}

// Returns the direction in which the worst cells, those within `margin` of the least, all grow: the shortest vector in
// the hull of their gradients (Gilbert's method).
Vec3d VertexStar::uphill(double margin) {
  active_.clear();
  for (std::size_t i = 0; i < qualities_.size(); ++i) {
    if (qualities_[i] <= least_ + margin) active_.push_back(gradients_[i]);
  }
  Vec3d shortest = active_.front();
  for (int round = 0; round < 30; ++round) {
    Vec3d next = active_.front();
    for (const Vec3d& g : active_) {
      if (dot(g, shortest) < dot(next, shortest)) next = g;
    }
    const Vec3d across = next - shortest;
    const double along = -dot(shortest, across);
    if (!(along > 1e-4 * norm2(shortest))) break;
    shortest += across * std::min(1.0, along / norm2(across));
  }
  return shortest;
}

bool VertexStar::climb(double margin, double goal) {
  const Vec3d direction = uphill(margin);
  const double length = norm(direction);
  if (!(length > 1e-9)) return false;
  const double before = least_;
  Vec3d best = place_;
  // Along the direction the worst cell grows by the length at least. So that is about the longest step that helps.
  double step = std::min(0.5 / length, 2 * (goal - least_) / (length * length));
  for (int halving = 0; halving < kHalvings; ++halving, step *= 0.5) {
    const Vec3d there = place_ + direction * step;
    const double least = least_at(there);
    if (least > least_) {
      best = there;
      least_ = least;
    } else if (least_ > before) {
      break;
    }
  }
  place_ = best;
  return least_ > before + kLeastGain;
}

void VertexStar::raise(double goal) {
  constexpr int most_steps = 8;
  if (cells_.empty() || !(size_ > 0)) return;
  for (int step = 0; step < most_steps && least_ < goal; ++step) {
    look_around();
    if (!climb(kWideMargin, goal) && !climb(0.1 * kWideMargin, goal)) return;
  }
}

}  // namespace knead::remesh_detail
