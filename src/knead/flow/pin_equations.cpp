#include "knead/flow/pin_equations.h"

#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_MPL2_ONLY
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "knead/field/dual.h"
#include "knead/field/field.h"
#include "knead/math/error.h"

namespace knead::detail {

namespace {

// Solutions are so much better than the polynomials, as far as rounding permits.
constexpr double kSolveShare = 0.03;
constexpr double kLeastError = 1e-14;  // of the greatest speed
constexpr int kMostRounds = 16;        // of conjugate gradients, before the matrix is factorised anew
// Without a factor a round costs a thirtieth for 2000 pins. The error is that of so many rounds ago.
constexpr std::size_t kPlainRounds = 200;
constexpr std::size_t kDelay = 10;

// At a pin the gradients of the representers of E and E' have the product 75 <E, E'> for antisymmetric ones, 45 for
// symmetric ones. A unit of a turn's unknowns is a rotation by sqrt(75 / 2), or sqrt(45) times a matrix of norm 1.
constexpr double kRotationUnit = 6.123724356957945246;
constexpr double kStrainUnit = 6.708203932499369089;
constexpr double kHalfRoot = 0.707106781186547524;  // 1 / sqrt(2)
constexpr double kSixthRoot = 0.408248290463863016;
constexpr std::size_t kStrains = 5;
constexpr std::size_t kMostUnknowns = 3 + 3 * kNodesOfTurn;  // of a pin; the last one is always 0

const std::array<Mat3d, kStrains> kStrainBasis{{
    {{kHalfRoot, 0, 0}, {0, -kHalfRoot, 0}, {0, 0, 0}},
    {{kSixthRoot, 0, 0}, {0, kSixthRoot, 0}, {0, 0, -2 * kSixthRoot}},
    {{0, kHalfRoot, 0}, {kHalfRoot, 0, 0}, {0, 0, 0}},
    {{0, 0, kHalfRoot}, {0, 0, 0}, {kHalfRoot, 0, 0}},
    {{0, 0, 0}, {0, 0, kHalfRoot}, {0, kHalfRoot, 0}},
}};

double product_of(const Mat3d& a, const Mat3d& b) {
  return dot(a.row0, b.row0) + dot(a.row1, b.row1) + dot(a.row2, b.row2);
}

Mat3d transposed(const Mat3d& m) { return {m.column(0), m.column(1), m.column(2)}; }

double dot_of(const Nodes& a, const Nodes& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
  return sum;
}

Vec3d axis(std::size_t i) {
  Vec3d e{0, 0, 0};
  e[i] = 1;
  return e;
}

// The field of one unit of a pin's unknown at y, in radii.
Vec3<Dual> unit_field(std::size_t unknown, const Vec3<Dual>& y) {
  const auto at = [&](const auto& motion, int falloff) {
    return velocity(motion, Ball<double>{}, Thresholds<double>{0, 1, falloff}, y, Dual(0));
  };
  if (unknown < 3) return at(Translation<double>{axis(unknown)}, kPinFalloff);
  if (unknown < 6) {
    return at(Rotation<double>{axis(unknown - 3), kRotationUnit, 0, RotationGauge::radial}, kPinRotationFalloff);
  }
  if (unknown < 6 + kStrains) {
    return at(Strain<double>{kStrainBasis[unknown - 6] * kStrainUnit}, kPinStrainFalloff);
  }
  return {};
}

using Unknowns = std::array<double, kMostUnknowns>;

// What the equations of a pin say of a field there.
Unknowns values_of(const Vec3<Dual>& v) {
  const Mat3d gradient{v.x.g, v.y.g, v.z.g};
  const Vec3d curl{v.z.g.y - v.y.g.z, v.x.g.z - v.z.g.x, v.y.g.x - v.x.g.y};
  Unknowns result{v.x.v, v.y.v, v.z.v};
  for (std::size_t i = 0; i < 3; ++i) result[3 + i] = curl[i] / (2 * kRotationUnit);
  for (std::size_t i = 0; i < kStrains; ++i) result[6 + i] = product_of(kStrainBasis[i], gradient) / kStrainUnit;
  return result;
}

[[noreturn]] void refuse() { throw InvalidInput("pins come too near each other; move them apart, or give fewer"); }

}  // namespace

struct PinEquations::Factor {
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> matrix;
};

TurnKernel turn_kernel(std::span<const Vec3d, kNodesOfTurn> nodes) {
  TurnKernel result{nodes[0] * kRotationUnit, {{}, {}, {}}};
  for (std::size_t i = 0; i < kStrains; ++i) {
    result.strain = result.strain + kStrainBasis[i] * (nodes[1 + i / 3][i % 3] * kStrainUnit);
  }
  return result;
}

PinEquations::PinEquations(const Segment& segment, double tolerance)
    : radius_(segment.fields.front().thresholds.outer), factor_(std::make_unique<Factor>()) {
  for (const Field& field : segment.fields) {
    places_.push_back(field.center);
    motions_.push_back(displacement_of(segment, field));
    right_.push_back(motions_.back());
  }
  turn_nodes_.resize(places_.size());
  for (const PinTurn& turn : segment.turns) {
    turn_nodes_[turn.pin] = static_cast<std::uint32_t>(right_.size());
    right_.push_back(turn.rate * (radius_ / kRotationUnit));
    right_.resize(right_.size() + kNodesOfTurn - 1);
  }
  find_pairs(std::min(segment.begin, segment.end), std::max(segment.begin, segment.end));
  double speed = 0;
  for (const Vec3d& u : right_) speed = std::max(speed, norm(u));
  error_ = std::max(kPinShare * tolerance, kLeastError / kSolveShare * speed);
}

PinEquations::~PinEquations() = default;

void PinEquations::find_pairs(double begin, double end) {
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    for (std::uint32_t j = i + 1; j < places_.size(); ++j) {
      const Vec3d d = places_[i] - places_[j];
      const Vec3d u = motions_[i] - motions_[j];
      const double speed2 = norm2(u);
      const double t = speed2 > 0 ? std::clamp(-dot(d, u) / speed2, begin, end) : begin;
      if (!(norm2(d + u * t) < radius_ * radius_)) continue;
      pairs_.push_back({i, j});
      add_couplings(pairs_.back());
      add_kinks(pairs_.back(), begin, end);
    }
  }
  blocks_.resize(couplings_.size());
  std::sort(kinks_.begin(), kinks_.end());
}

// The roots of |d + u t| = R.
void PinEquations::add_kinks(const Pair& pair, double begin, double end) {
  if (turn_nodes_[pair.first] == 0 && turn_nodes_[pair.second] == 0) return;
  const Vec3d d = places_[pair.first] - places_[pair.second];
  const Vec3d u = motions_[pair.first] - motions_[pair.second];
  const double speed2 = norm2(u);
  const double root2 = dot(d, u) * dot(d, u) - speed2 * (norm2(d) - radius_ * radius_);
  if (!(speed2 > 0 && root2 > 0)) return;
  for (const double root : {-std::sqrt(root2), std::sqrt(root2)}) {
    const double t = (root - dot(d, u)) / speed2;
    if (t > begin && t < end) kinks_.push_back(t);
  }
}

// Every node of the one with every node of the other, as set_time() fills their blocks.
void PinEquations::add_couplings(const Pair& pair) {
  const auto nodes_of = [&](std::uint32_t pin) {
    std::vector<std::uint32_t> nodes{pin};
    for (std::uint32_t k = 0; turn_nodes_[pin] != 0 && k < kNodesOfTurn; ++k) nodes.push_back(turn_nodes_[pin] + k);
    return nodes;
  };
  for (const std::uint32_t row : nodes_of(pair.first)) {
    for (const std::uint32_t column : nodes_of(pair.second)) {
      couplings_.push_back({std::min(row, column), std::max(row, column)});
    }
  }
}

void PinEquations::set_time(double t) {
  std::size_t next = 0;
  for (const Pair& pair : pairs_) {
    const Vec3d y =
        ((places_[pair.first] - places_[pair.second]) + (motions_[pair.first] - motions_[pair.second]) * t) / radius_;
    const std::size_t rows = turn_nodes_[pair.first] != 0 ? 1 + kNodesOfTurn : 1;
    const std::size_t columns = turn_nodes_[pair.second] != 0 ? 1 + kNodesOfTurn : 1;
    if (rows * columns == 1) {
      blocks_[next++] = pin_kernel(y);
      continue;
    }
    std::array<Unknowns, kMostUnknowns> values{};  // by column
    for (std::size_t k = 0; k < 3 * columns; ++k) values[k] = values_of(unit_field(k, variables(y)));
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t column = 0; column < columns; ++column) {
        const auto part = [&](std::size_t r) {
          return Vec3d{values[3 * column][3 * row + r], values[3 * column + 1][3 * row + r],
                       values[3 * column + 2][3 * row + r]};
        };
        const Mat3d block{part(0), part(1), part(2)};
        const bool is_in_order =
            (row == 0 ? pair.first : turn_nodes_[pair.first]) < (column == 0 ? pair.second : turn_nodes_[pair.second]);
        blocks_[next++] = is_in_order ? block : transposed(block);
      }
    }
  }
}

Nodes PinEquations::product(const Nodes& a) const {
  Nodes result = a;
  for (std::size_t k = 0; k < couplings_.size(); ++k) {
    result[couplings_[k].first] += blocks_[k] * a[couplings_[k].second];
    result[couplings_[k].second] += transposed(blocks_[k]) * a[couplings_[k].first];
  }
  return result;
}

// By conjugate gradients; from the first time on at which these are slow, with the last factorised matrix, or with this
// one if that does not do. The error in v is at most sqrt(e.Me) for an error e, by the norm in which the kernels
// reproduce values; that is what ends the rounds.
void PinEquations::solve(Nodes& a) {
  const bool has_factor = factor_->matrix.rows() != 0;
  if (has_factor ? improve(a) : improve_without_factor(a)) return;
  factorise();
  if (!improve(a)) refuse();
}

double PinEquations::error_of(const Nodes& a, const Nodes& solution) const {
  Nodes e = a;
  for (std::size_t i = 0; i < e.size(); ++i) e[i] -= solution[i];
  return std::sqrt(std::max(dot_of(e, product(e)), 0.0));
}

void PinEquations::factorise() {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(3 * size() + 9 * couplings_.size());
  for (int i = 0; i < 3 * static_cast<int>(size()); ++i) entries.emplace_back(i, i, 1.0);
  for (std::size_t k = 0; k < couplings_.size(); ++k) {
    for (int r = 0; r < 3; ++r) {
      const Vec3d row = blocks_[k].column(static_cast<std::size_t>(r));  // of the transposed block, below the diagonal
      for (int c = 0; c < 3; ++c) {
        entries.emplace_back(3 * static_cast<int>(couplings_[k].second) + r,
                             3 * static_cast<int>(couplings_[k].first) + c, row[static_cast<std::size_t>(c)]);
      }
    }
  }
  const auto n = static_cast<int>(3 * size());
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  auto& factor = factor_->matrix;
  if (factor.rows() == 0) factor.analyzePattern(matrix);  // which is the same at all times
  factor.factorize(matrix);
  if (factor.info() != Eigen::Success) refuse();
}

Nodes PinEquations::by_factor(const Nodes& right) const {
  Eigen::VectorXd in(3 * static_cast<Eigen::Index>(right.size()));
  for (std::size_t i = 0; i < right.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) in[static_cast<Eigen::Index>(3 * i + k)] = right[i][k];
  }
  const Eigen::VectorXd out = factor_->matrix.solve(in);
  Nodes result(right.size());
  for (std::size_t i = 0; i < right.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) result[i][k] = out[static_cast<Eigen::Index>(3 * i + k)];
  }
  return result;
}

// Returns whether `a` has become the solution. In each round e.Me falls by the step times the square of the rest
// (Hestenes and Stiefel). The sum of the last falls is nearly what e.Me was before them.
bool PinEquations::improve_without_factor(Nodes& a) const {
  Nodes rest = right_;
  const Nodes there = product(a);
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= there[i];
  Nodes direction = rest;
  double square = dot_of(rest, rest);
  std::array<double, kDelay> falls{};
  const double enough = kSolveShare * error_;
  for (std::size_t round = 0; round < kPlainRounds; ++round) {
    if (square == 0) return true;
    const Nodes image = product(direction);
    const double step = square / dot_of(direction, image);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      a[i] += direction[i] * step;
      rest[i] -= image[i] * step;
    }
    falls[round % kDelay] = step * square;
    if (round + 1 >= kDelay && std::accumulate(falls.begin(), falls.end(), 0.0) <= enough * enough) return true;
    const double last = std::exchange(square, dot_of(rest, rest));
    for (std::size_t i = 0; i < rest.size(); ++i) direction[i] = rest[i] + direction[i] * (square / last);
  }
  return false;
}

// The same with the factor, whose product with the rest estimates e.Me.
bool PinEquations::improve(Nodes& a) const {
  Nodes rest = right_;
  const Nodes there = product(a);
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= there[i];
  Nodes direction;
  double last = 0;
  const double enough = kSolveShare * error_;
  for (int round = 0; round < kMostRounds; ++round) {
    const Nodes better = by_factor(rest);
    const double now = dot_of(rest, better);
    if (now <= enough * enough) return true;
    if (round == 0) direction = better;
    for (std::size_t i = 0; round > 0 && i < rest.size(); ++i) direction[i] = better[i] + direction[i] * (now / last);
    last = now;
    const Nodes image = product(direction);
    const double step = now / dot_of(direction, image);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      a[i] += direction[i] * step;
      rest[i] -= image[i] * step;
    }
  }
  return false;
}

}  // namespace knead::detail
