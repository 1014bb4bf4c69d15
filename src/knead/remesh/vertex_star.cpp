#include "knead/remesh/vertex_star.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "knead/mesh/cell_shape.h"
#include "knead/remesh/best_step.h"

namespace knead::remesh_detail {

namespace {

// Other vertices move later, too, and then this one again: so none is brought to its best place.
constexpr int kSteps = 2;
constexpr int kHalvings = 4;
constexpr double kLongestStep = 0.5;
constexpr double kLeastGain = 1e-3;

}  // namespace

void VertexStar::read(const JudgedCells& judged, const CellStars& stars, std::span<const Vec3d> points,
                      std::uint32_t vertex) {
  tetrahedra_.clear();
  corners_.clear();
  start_ = points[vertex];
  place_ = {0, 0, 0};
  size_ = 0;
  for (const std::uint32_t number : stars.of(vertex)) {
    for (const std::uint32_t corner : judged.cells().corners_of(number)) {
      size_ = std::max(size_, norm2(points[corner] - start_));
    }
  }
  size_ = std::sqrt(size_);
  if (!(size_ > 0)) return;
  for (const std::uint32_t number : stars.of(vertex)) {
    if (judged.side(number) != 0) add(judged, number, points, vertex);
  }
  least_ = -std::numeric_limits<double>::infinity();
  least_ = least_at(place_);
}

void VertexStar::add(const JudgedCells& judged, std::uint32_t number, std::span<const Vec3d> points,
                     std::uint32_t vertex) {
  const std::span<const std::uint32_t> numbers = judged.cells().corners_of(number);
  const CellShape& shape = shape_of(judged.cells().kinds[number]);
  const double factor = judged.side(number) * shape.regular;
  const auto seen = [&](std::size_t k) { return (points[numbers[k]] - start_) * (1 / size_); };
  const auto at = static_cast<std::size_t>(std::find(numbers.begin(), numbers.end(), vertex) - numbers.begin());
  for (const CellCorner& corner : shape.corners) {
    if (corner[0] == at && numbers.size() == 4) {
      tetrahedra_.emplace_back(std::array{seen(corner[1]), seen(corner[2]), seen(corner[3])}, factor);
    } else if (corner[0] == at) {
      corners_.push_back(SeenCorner::of_vertex({seen(corner[1]), seen(corner[2]), seen(corner[3])}, factor));
    }
    for (std::size_t k = 1; k < 4 && numbers.size() != 4; ++k) {
      if (corner[k] != at) continue;
      corners_.push_back(
          SeenCorner::beside(seen(corner[0]), seen(corner[k % 3 + 1]), seen(corner[(k + 1) % 3 + 1]), factor));
    }
  }
}

// Stops at the first value below the least so far.
double VertexStar::least_at(const Vec3d& place) const {
  double least = std::numeric_limits<double>::infinity();
  for (const SeenTetrahedron& cell : tetrahedra_) {
    least = std::min(least, cell.quality(place));
    if (least < least_) return least;
  }
  for (const SeenCorner& corner : corners_) {
    least = std::min(least, corner.quality(place));
    if (least < least_) return least;
  }
  return least;
}

void VertexStar::look_around() {
  values_.clear();
  gradients_.clear();
  const auto keep = [&](const Slant& slant) {
    values_.push_back(slant.value);
    gradients_.push_back(slant.gradient);
  };
  for (const SeenTetrahedron& cell : tetrahedra_) keep(cell.slant(place_));
  for (const SeenCorner& corner : corners_) keep(corner.slant(place_));
}

bool VertexStar::climb(double reach, double goal) {
  look_around();
  Vec3d step = best_step(values_, gradients_, reach);
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
  if (tetrahedra_.empty() && corners_.empty()) return;
  double reach = 1;
  for (int step = 0; step < kSteps && least_ < goal; ++step) {
    if (!climb(reach, goal)) reach *= 0.25;
  }
}

}  // namespace knead::remesh_detail
