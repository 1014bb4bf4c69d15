#include "knead/remesh/best_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace knead::remesh_detail {

namespace {

constexpr std::size_t kMost = 5;  // four that count, and one that comes in
using Row = std::array<double, kMost>;

// A symmetric positive definite matrix as the product of a lower triangle and its transpose.
class Triangle {
 public:
  explicit Triangle(std::size_t size) : size_(size) {}

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
  std::array<Row, kMost> rows_{};
};

class Search {
 public:
  Search(std::span<const double> values, std::span<const Vec3d> gradients, double reach)
      : values_(values), gradients_(gradients), reach_(reach) {
    add(static_cast<std::size_t>(std::min_element(values.begin(), values.end()) - values.begin()), 1);
  }

  Vec3d run() {
    constexpr int most_rounds = 30;
    constexpr double negligible = 1e-4;
    for (int round = 0; round < most_rounds && count_ < kMost; ++round) {
      const Vec3d d = step();
      const auto there = [&](std::size_t i) { return values_[i] + dot(gradients_[i], d); };
      std::size_t low = 0;
      double lowest = there(0);
      for (std::size_t i = 1; i < values_.size(); ++i) {
        const double value = there(i);
        if (!(value < lowest)) continue;
        low = i;
        lowest = value;
      }
      double held = 0;
      for (std::size_t k = 0; k < count_; ++k) held += weights_[k] * there(members_[k]);
      if (!(held - lowest > negligible)) break;
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
    Triangle triangle(count_);
    Row ones{};
    Row values{};
    for (std::size_t i = 0; i < count_; ++i) {
      Row row{};
      for (std::size_t j = 0; j <= i; ++j) row[j] = reach_ * dot(gradients_[members_[i]], gradients_[members_[j]]);
      // Gradients may depend on each other.
      const double least = 1e-9 * row[i] + 1e-14;
      row[i] += least;
      triangle.set_row(i, row, least);
      ones[i] = 1;
      values[i] = values_[members_[i]];
    }
    const Row of_ones = triangle.solve(ones);
    Row result = triangle.solve(values);
    double sum = 1;
    double slope = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      sum += result[i];
      slope += of_ones[i];
    }
    for (std::size_t i = 0; i < count_; ++i) result[i] = sum / slope * of_ones[i] - result[i];
    return result;
  }

  // Goes to the levelling weights, and leaves out members whose weight falls to 0 on that line.
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
  std::array<std::size_t, kMost> members_{};
  Row weights_{};
  std::size_t count_ = 0;
};

}  // namespace

Vec3d best_step(std::span<const double> values, std::span<const Vec3d> gradients, double reach) {
  return Search(values, gradients, reach).run();
}

}  // namespace knead::remesh_detail
