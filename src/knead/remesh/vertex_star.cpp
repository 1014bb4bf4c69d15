#include "knead/remesh/vertex_star.h"

#include <algorithm>
#include <cmath>

#include "knead/remesh/best_step.h"

namespace knead::remesh_detail {

namespace {

// Other vertices move later, too, and then this one again: so none is brought to its best place.
constexpr int kSteps = 2;
constexpr int kHalvings = 4;
constexpr double kLongestStep = 0.5;
constexpr double kLeastGain = 1e-3;

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
      size_ = std::max(size_, norm2(cell.corners[k]));
    }
  }
  size_ = std::sqrt(size_);
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

// Measures each cell, and how its quality grows with the vertex's place.
void VertexStar::look_around() {
  qualities_.resize(cells_.size());
  gradients_.resize(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    qualities_[i] = quality(cells_[i], place_);
    gradients_[i] = gradient(cells_[i], place_);
  }
}

bool VertexStar::climb(double reach, double goal) {
  look_around();
  Vec3d step = best_step(qualities_, gradients_, reach);
  const double length = norm(step);
  if (length > kLongestStep) step *= kLongestStep / length;
  const double before = least_;
  const Vec3d start = place_;
  for (int halving = 0; halving < kHalvings && least_ < goal; ++halving, step *= 0.5) {
    const double least = least_at(start + step);
    if (least > least_) {
      place_ = start + step;
      least_ = least;
    } else if (least_ > before) {
      break;
    }
  }
  return least_ > before + kLeastGain;
}

void VertexStar::raise(double goal) {
  if (cells_.empty() || !(size_ > 0)) return;
  double reach = 1;
  for (int step = 0; step < kSteps && least_ < goal; ++step) {
    if (!climb(reach, goal)) reach *= 0.25;
  }
}

}  // namespace knead::remesh_detail
