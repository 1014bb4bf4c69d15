#include "knead/flow/pins.h"

#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_MPL2_ONLY
#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "knead/math/error.h"
#include "knead/math/mat3.h"

namespace knead::detail {

namespace {

// Nodes of a piece are those of Chebyshev and Lobatto, so that those of a degree are nodes of twice the degree too.
constexpr int kMostDegree = 8;
constexpr int kNodes = 2 * kMostDegree;  // and one
constexpr std::array<double, kNodes / 2 + 1> kCosines{1,
                                                      0.98078528040323044913,
                                                      0.92387953251128675613,
                                                      0.83146961230254523708,
                                                      0.70710678118654752440,
                                                      0.55557023301960222474,
                                                      0.38268343236508977173,
                                                      0.19509032201612826785,
                                                      0};
constexpr double kShortestPiece = 1.0 / 4096;
// Solutions are so much better than the polynomials, as far as rounding permits.
constexpr double kSolveShare = 0.03;
constexpr double kLeastError = 1e-14;  // of the greatest speed
constexpr int kMostRounds = 16;        // of conjugate gradients, before the matrix is factorised anew

double node(int k) { return k <= kNodes / 2 ? kCosines[static_cast<std::size_t>(k)] : -node(kNodes - k); }

using Velocities = std::vector<Vec3d>;

double dot_of(const Velocities& a, const Velocities& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
  return sum;
}

// Two pins that are in each other's reach at some time.
struct Pair {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
};

// The equations at any time.
class PinEquations {
 public:
  PinEquations(const Segment& segment, double tolerance) : radius_(segment.fields.front().thresholds.outer) {
    for (const Field& field : segment.fields) {
      places_.push_back(field.center);
      motions_.push_back(std::get<Translation<double>>(field.motion).velocity);
    }
    find_pairs(std::min(segment.begin, segment.end), std::max(segment.begin, segment.end));
    double speed = 0;
    for (const Vec3d& u : motions_) speed = std::max(speed, norm(u));
    error_ = std::max(kPinShare * tolerance, kLeastError / kSolveShare * speed);
  }

  std::size_t size() const { return places_.size(); }

  // In v, anywhere.
  double error() const { return error_; }

  // Makes t the time of what follows. From time to time the matrix is factorised; else it is near to the last that was.
  void set_time(double t) {
    blocks_.clear();
    for (const Pair& pair : pairs_) {
      const Vec3d between =
          (places_[pair.first] - places_[pair.second]) + (motions_[pair.first] - motions_[pair.second]) * t;
      blocks_.push_back(pin_kernel(between / radius_));
    }
  }

  // M a.
  Velocities product(const Velocities& a) const {
    Velocities result = a;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      result[pairs_[k].first] += blocks_[k] * a[pairs_[k].second];
      result[pairs_[k].second] += blocks_[k] * a[pairs_[k].first];
    }
    return result;
  }

  // Makes `a` the solution: by conjugate gradients with the last factorised matrix, or with this one if that does not
  // do. The error in v is at most sqrt(e.Me) for an error e, by the norm in which Psi reproduces values; that is what
  // ends the rounds.
  void solve(Velocities& a) {
    if (factor_.rows() != 0 && improve(a)) return;
    factorise();
    if (!improve(a)) throw InvalidInput("pins come too near each other; move them apart, or give fewer");
  }

  // A bound for the error of v with `a`, given the solution.
  double error_of(const Velocities& a, const Velocities& solution) const {
    Velocities e = a;
    for (std::size_t i = 0; i < e.size(); ++i) e[i] -= solution[i];
    return std::sqrt(std::max(dot_of(e, product(e)), 0.0));
  }

 private:
  void find_pairs(double begin, double end) {
    for (std::uint32_t i = 0; i < places_.size(); ++i) {
      for (std::uint32_t j = i + 1; j < places_.size(); ++j) {
        const Vec3d d = places_[i] - places_[j];
        const Vec3d u = motions_[i] - motions_[j];
        const double speed2 = norm2(u);
        const double t = speed2 > 0 ? std::clamp(-dot(d, u) / speed2, begin, end) : begin;
        if (norm2(d + u * t) < radius_ * radius_) pairs_.push_back({i, j});
      }
    }
  }

  void factorise() {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(3 * size() + 9 * pairs_.size());
    for (int i = 0; i < 3 * static_cast<int>(size()); ++i) entries.emplace_back(i, i, 1.0);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const std::array<Vec3d, 3> rows{blocks_[k].row0, blocks_[k].row1, blocks_[k].row2};
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          const double value = rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
          entries.emplace_back(3 * static_cast<int>(pairs_[k].second) + r, 3 * static_cast<int>(pairs_[k].first) + c,
                               value);
        }
      }
    }
    const auto n = static_cast<int>(3 * size());
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    if (factor_.rows() == 0) factor_.analyzePattern(matrix);  // which is the same at all times
    factor_.factorize(matrix);
    if (factor_.info() != Eigen::Success) {
      throw InvalidInput("pins come too near each other; move them apart, or give fewer");
    }
  }

  Velocities by_factor(const Velocities& right) const {
    Eigen::VectorXd in(3 * static_cast<Eigen::Index>(right.size()));
    for (std::size_t i = 0; i < right.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) in[static_cast<Eigen::Index>(3 * i + axis)] = right[i][axis];
    }
    const Eigen::VectorXd out = factor_.solve(in);
    Velocities result(right.size());
    for (std::size_t i = 0; i < right.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) result[i][axis] = out[static_cast<Eigen::Index>(3 * i + axis)];
    }
    return result;
  }

  // Returns whether `a` has become the solution.
  bool improve(Velocities& a) const {
    Velocities rest = motions_;
    const Velocities there = product(a);
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= there[i];
    Velocities direction;
    double last = 0;
    const double enough = kSolveShare * error_;
    for (int round = 0; round < kMostRounds; ++round) {
      const Velocities better = by_factor(rest);
      const double now = dot_of(rest, better);
      if (now <= enough * enough) return true;
      if (round == 0) direction = better;
      for (std::size_t i = 0; round > 0 && i < rest.size(); ++i) direction[i] = better[i] + direction[i] * (now / last);
      last = now;
      const Velocities image = product(direction);
      const double step = now / dot_of(direction, image);
      for (std::size_t i = 0; i < rest.size(); ++i) {
        a[i] += direction[i] * step;
        rest[i] -= image[i] * step;
      }
    }
    return false;
  }

  double radius_;
  double error_ = 0;
  std::vector<Vec3d> places_;  // at t = 0
  std::vector<Vec3d> motions_;
  std::vector<Pair> pairs_;
  std::vector<Mat3d> blocks_;  // of the pairs, at the time
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

// The pieces of one segment.
class PinSolver {
 public:
  PinSolver(const Segment& segment, double tolerance, const Progress* progress)
      : equations_(segment, tolerance), progress_(progress) {}

  std::vector<PinPiece> run(double begin, double end) {
    try {
      add(begin, end);
    } catch (const Cancelled&) {
      return {};
    }
    return std::move(pieces_);
  }

 private:
  // One piece, or two halves of it, and so on.
  void add(double begin, double end) {
    begin_ = begin;
    end_ = end;
    for (auto& solution : solutions_) solution.reset();
    const Velocities* guess = &solution_at(kNodes / 2, nullptr);
    for (int degree = 1; degree <= kMostDegree; degree *= 2) {
      if (fits(degree, guess)) return;
    }
    const double middle = 0.5 * (begin + end);
    if (end - begin <= kShortestPiece) {
      throw InvalidInput(fmt::format("pins come too near each other about the time {:.4g}; move them apart", middle));
    }
    add(begin, middle);
    add(middle, end);
  }

  // Adds the polynomial of the degree if it is right at the nodes that twice the degree has besides.
  bool fits(int degree, const Velocities* guess) {
    const int stride = kNodes / degree;
    for (int k = 0; k <= kNodes; k += stride) solution_at(k, guess);
    PinPiece piece = interpolated(degree);
    Velocities there(equations_.size());
    for (int k = stride / 2; k <= kNodes; k += stride) {
      for (std::size_t i = 0; i < there.size(); ++i) there[i] = piece.at(i, time_of(k));
      const Velocities& solution = solution_at(k, &there);
      equations_.set_time(time_of(k));
      if (!(equations_.error_of(there, solution) <= equations_.error())) return false;
    }
    pieces_.push_back(std::move(piece));
    return true;
  }

  double time_of(int k) const {
    if (k == 0) return end_;
    if (k == kNodes) return begin_;
    return 0.5 * (begin_ + end_) + 0.5 * (end_ - begin_) * node(k);
  }

  const Velocities& solution_at(int k, const Velocities* guess) {
    std::optional<Velocities>& solution = solutions_[static_cast<std::size_t>(k)];
    if (solution) return *solution;
    stop_if_cancelled(progress_);
    equations_.set_time(time_of(k));
    Velocities a = guess != nullptr ? *guess : Velocities(equations_.size());
    equations_.solve(a);
    return solution.emplace(std::move(a));
  }

  // Newton's form of the polynomial through the solutions at the nodes of the degree, in powers of s.
  PinPiece interpolated(int degree) const {
    PinPiece piece{begin_, end_, degree, {}};
    const int stride = kNodes / degree;
    std::array<Vec3d, kMostDegree + 1> f;
    std::array<Vec3d, kMostDegree + 1> powers;
    const auto at = [](int i) { return static_cast<std::size_t>(i); };
    for (std::size_t pin = 0; pin < equations_.size(); ++pin) {
      for (int k = 0; k <= degree; ++k) f[at(k)] = (*solutions_[at(k * stride)])[pin];
      for (int order = 1; order <= degree; ++order) {
        for (int k = degree; k >= order; --k) {
          f[at(k)] = (f[at(k)] - f[at(k - 1)]) / (node(k * stride) - node((k - order) * stride));
        }
      }
      powers.fill({});
      for (int k = degree; k >= 0; --k) {
        for (int power = degree; power > 0; --power) {
          powers[at(power)] = powers[at(power - 1)] - powers[at(power)] * node(k * stride);
        }
        powers[0] = f[at(k)] - powers[0] * node(k * stride);
      }
      piece.coefficients.insert(piece.coefficients.end(), powers.begin(), powers.begin() + degree + 1);
    }
    return piece;
  }

  PinEquations equations_;
  const Progress* progress_;
  double begin_ = 0;
  double end_ = 1;
  std::array<std::optional<Velocities>, kNodes + 1> solutions_;  // of the piece in work
  std::vector<PinPiece> pieces_;
};

}  // namespace

Vec3d PinPiece::at(std::size_t pin, double t) const {
  const double s = (2 * t - begin - end) / (end - begin);
  const Vec3d* const of_pin = coefficients.data() + pin * (static_cast<std::size_t>(degree) + 1);
  Vec3d value = of_pin[degree];
  for (int power = degree - 1; power >= 0; --power) value = of_pin[power] + value * s;
  return value;
}

std::vector<PinPiece> solve_pins(const Segment& segment, double tolerance, const Progress* progress) {
  const auto [begin, end] = std::minmax(segment.begin, segment.end);
  if (begin == end) return {};
  return PinSolver(segment, tolerance, progress).run(begin, end);
}

std::vector<Field> fields_at(const Segment& segment, const std::vector<PinPiece>& pieces, double t) {
  auto piece = std::upper_bound(pieces.begin(), pieces.end(), t,
                                [](double time, const PinPiece& next) { return time < next.begin; });
  if (piece != pieces.begin()) --piece;
  std::vector<Field> fields = segment.fields;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    fields[i].center += displacement_of(segment, fields[i]) * t;
    fields[i].motion = Translation<double>{piece->at(i, t)};
  }
  return fields;
}

}  // namespace knead::detail
