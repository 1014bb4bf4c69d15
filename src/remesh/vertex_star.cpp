// The qualities of cells as functions of the position of one vertex, and the steps that raise the least of them.
#include "remesh/vertex_star.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "cells/cells.h"

namespace knead::detail {

namespace {

// Few steps are enough: other vertices move later, and then this one again.
constexpr int kMaxSteps = 2;
constexpr int kMaxStarHalvings = 4;
constexpr double kMaxStarStep = 0.5;
constexpr double kMinRise = 1e-3;

constexpr std::size_t kMaxMembers = 5;  // four with a weight, and one that enters
using Row = std::array<double, kMaxMembers>;

// A symmetric positive definite matrix as the product of a lower triangle and its transpose.
class Factor {
 public:
  explicit Factor(std::size_t size) : size_(size) {}

  // Rows must be set in order. A pivot below `least` is raised to it.
  void set_row(std::size_t i, Row row, double least) {
    for (std::size_t j = 0; j <= i; ++j) {
      for (std::size_t k = 0; k < j; ++k) row[j] -= rows_[i][k] * rows_[j][k];
      rows_[i][j] = i == j ? std::sqrt(std::max(row[j], least)) : row[j] / rows_[j][j];
    }
  }

  Row solve(Row x) const {
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t k = 0; k < i; ++k) x[i] -= rows_[i][k] * x[k];
      x[i] /= rows_[i][i];
    }
    for (std::size_t i = size_; i-- > 0;) {
      for (std::size_t k = i + 1; k < size_; ++k) x[i] -= rows_[k][i] * x[k];
      x[i] /= rows_[i][i];
    }
    return x;
  }

 private:
  std::size_t size_;
  std::array<Row, kMaxMembers> rows_{};
};

// Finds the weights of best_step().
class ActiveSet {
 public:
  ActiveSet(std::span<const double> values, std::span<const Vec3d> gradients, double reach)
      : values_(values), gradients_(gradients), reach_(reach) {
    add(static_cast<std::size_t>(std::min_element(values.begin(), values.end()) - values.begin()), 1);
  }

  Vec3d run() {
    constexpr int kMaxSetRounds = 30;
    constexpr double kMinGap = 1e-4;
    for (int round = 0; round < kMaxSetRounds && count_ < kMaxMembers; ++round) {
      const Vec3d d = step();
      const auto value_at = [&](std::size_t i) { return values_[i] + dot(gradients_[i], d); };
      std::size_t low = 0;
      double lowest = value_at(0);
      for (std::size_t i = 1; i < values_.size(); ++i) {
        const double value = value_at(i);
        if (!(value < lowest)) continue;
        low = i;
        lowest = value;
      }
      double held = 0;
      for (std::size_t k = 0; k < count_; ++k) held += weights_[k] * value_at(members_[k]);
      if (!(held - lowest > kMinGap)) break;
      add(low, 0);
      settle();
    }
    return step();
  }

 private:
  void add(std::size_t member, double weight) {
    members_[count_] = member;
    weights_[count_++] = weight;
  }

  Vec3d step() const {
    Vec3d sum{0, 0, 0};
    for (std::size_t k = 0; k < count_; ++k) sum += gradients_[members_[k]] * weights_[k];
    return sum * reach_;
  }

  // Returns the weights of sum 1, also negative ones, with which all members reach the same value.
  Row levelling() const {
    Factor factor(count_);
    Row ones{};
    Row values{};
    for (std::size_t i = 0; i < count_; ++i) {
      Row row{};
      for (std::size_t j = 0; j <= i; ++j) row[j] = reach_ * dot(gradients_[members_[i]], gradients_[members_[j]]);
      // Gradients may depend on each other.
      const double least = 1e-9 * row[i] + 1e-14;
      row[i] += least;
      factor.set_row(i, row, least);
      ones[i] = 1;
      values[i] = values_[members_[i]];
    }
    const Row of_ones = factor.solve(ones);
    Row result = factor.solve(values);
    double sum = 1;
    double slope = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      sum += result[i];
      slope += of_ones[i];
    }
    for (std::size_t i = 0; i < count_; ++i) result[i] = sum / slope * of_ones[i] - result[i];
    return result;
  }

  // Moves to the levelling weights and drops members whose weight falls to 0 on that line.
  void settle() {
    for (std::size_t before = count_ + 1; count_ < before && count_ > 1;) {
      before = count_;
      const Row wanted = levelling();
      double part = 1;
      for (std::size_t k = 0; k < count_; ++k) {
        if (wanted[k] < 0) part = std::min(part, weights_[k] / (weights_[k] - wanted[k]));
      }
      count_ = 0;
      for (std::size_t k = 0; k < before; ++k) {
        const double weight = weights_[k] + part * (wanted[k] - weights_[k]);
        if (weight > 1e-12) add(members_[k], weight);
      }
    }
  }

  std::span<const double> values_;
  std::span<const Vec3d> gradients_;
  double reach_;
  std::array<std::size_t, kMaxMembers> members_{};
  Row weights_{};
  std::size_t count_ = 0;
};

}  // namespace

// The corners of a tetrahedron with the vertex at one position, and which of them has the least Jacobian.
struct SeenTetrahedron::Corners {
  std::array<Vec3d, 3> to;  // the other corners
  std::array<double, 3> squares;
  double determinant;
  double product = 0;
  std::size_t worst = 0;  // the corner; 3: the vertex

  Corners(const SeenTetrahedron& seen, const Vec3d& position)
      : to{seen.others_[0] - position, seen.others_[1] - position, seen.others_[2] - position},
        squares{norm2(to[0]), norm2(to[1]), norm2(to[2])},
        determinant(dot(to[0], seen.across_)) {
    const std::array<double, 4> products{squares[0] * seen.opposite_[0], squares[1] * seen.opposite_[1],
                                         squares[2] * seen.opposite_[2], squares[0] * squares[1] * squares[2]};
    // `across_` has the sign of the factor.
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

double SeenTetrahedron::quality(const Vec3d& position) const {
  const Corners corners(*this, position);
  return corners.product > 0 ? factor_ * (corners.determinant / std::sqrt(corners.product)) : 0;
}

LinearApproximation SeenTetrahedron::linear(const Vec3d& position) const {
  const Corners corners(*this, position);
  if (!(corners.product > 0)) return {0, {0, 0, 0}};
  const double root = std::sqrt(corners.product);
  Vec3d relative{0, 0, 0};  // the gradient of the product, relative to it
  for (std::size_t k = 0; k < 3; ++k) {
    if (corners.worst == 3 || corners.worst == k) relative -= corners.to[k] / corners.squares[k];
  }
  return {factor_ * (corners.determinant / root), (across_ + relative * corners.determinant) * (-factor_ / root)};
}

SeenCorner SeenCorner::beside(const Vec3d& origin, const Vec3d& next, const Vec3d& last, double factor) {
  const double lengths = norm(next - origin) * norm(last - origin);
  const Vec3d across = lengths > 0 ? cross(next - origin, last - origin) / lengths : Vec3d{0, 0, 0};
  return {false, {origin, across, {}}, factor};
}

LinearApproximation SeenCorner::linear(const Vec3d& position) const {
  if (!is_vertex_) {
    const Vec3d edge = position - points_[0];
    const double length = norm(edge);
    if (!(length > 0)) return {0, {0, 0, 0}};
    const double value = dot(edge, points_[1]) / length;
    return {factor_ * value, (points_[1] - edge * (value / length)) * (factor_ / length)};
  }
  const Vec3d a = points_[0] - position;
  const Vec3d b = points_[1] - position;
  const Vec3d c = points_[2] - position;
  const double lengths = norm(a) * norm(b) * norm(c);
  if (!(lengths > 0)) return {0, {0, 0, 0}};
  const Vec3d across = cross(a, b);
  const double value = dot(across, c) / lengths;
  const Vec3d growth = (across + cross(b, c) + cross(c, a)) / -lengths;
  return {factor_ * value, (growth + (a / norm2(a) + b / norm2(b) + c / norm2(c)) * value) * factor_};
}

Vec3d best_step(std::span<const double> values, std::span<const Vec3d> gradients, double reach) {
  return ActiveSet(values, gradients, reach).run();
}

void VertexStar::read(const CellBaseline& judged, const CellStars& stars, std::span<const Vec3d> points,
                      std::uint32_t vertex) {
  tetrahedra_.clear();
  corners_.clear();
  start_ = points[vertex];
  position_ = {0, 0, 0};
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
  least_ = -kInfinity;
  least_ = least_at(position_);
}

void VertexStar::add(const CellBaseline& judged, std::uint32_t number, std::span<const Vec3d> points,
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
double VertexStar::least_at(const Vec3d& position) const {
  double least = kInfinity;
  for (const SeenTetrahedron& cell : tetrahedra_) {
    least = std::min(least, cell.quality(position));
    if (least < least_) return least;
  }
  for (const SeenCorner& corner : corners_) {
    least = std::min(least, corner.quality(position));
    if (least < least_) return least;
  }
  return least;
}

void VertexStar::linearise() {
  values_.clear();
  gradients_.clear();
  const auto keep = [&](const LinearApproximation& linear) {
    values_.push_back(linear.value);
    gradients_.push_back(linear.gradient);
  };
  for (const SeenTetrahedron& cell : tetrahedra_) keep(cell.linear(position_));
  for (const SeenCorner& corner : corners_) keep(corner.linear(position_));
}

bool VertexStar::climb(double reach, double goal) {
  linearise();
  Vec3d step = best_step(values_, gradients_, reach);
  const double length = norm(step);
  if (length > kMaxStarStep) step *= kMaxStarStep / length;
  const double before = least_;
  const Vec3d start = position_;
  for (int halving = 0; halving < kMaxStarHalvings && least_ < goal; ++halving, step *= 0.5) {
    const double least = least_at(start + step);
    if (least > least_) {
      position_ = start + step;
      least_ = least;
    } else if (least_ > before) {
      break;
    }
  }
  return least_ > before + kMinRise;
}

void VertexStar::raise(double goal) {
  if (tetrahedra_.empty() && corners_.empty()) return;
  double reach = 1;
  for (int step = 0; step < kMaxSteps && least_ < goal; ++step) {
    if (!climb(reach, goal)) reach *= 0.25;
  }
}

}  // namespace knead::detail
