// Solves the equations of pins, and fits polynomials of the time to the solutions.
#include "flow/pins.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "field/dual.h"
#include "knead/error.h"
#include "knead/field.h"
#include "math/elementary.h"
#include "math/geometry.h"
#include "math/sparse_cholesky.h"

#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_MPL2_ONLY
#include <Eigen/OrderingMethods>

namespace knead::detail {

namespace {

constexpr double kSolveShare = 0.03;  // of the polynomials' error: that of the solutions, as far as rounding permits
constexpr double kMinError = 1e-14;   // of the greatest speed
constexpr int kMaxRounds = 16;        // of conjugate gradients, before the matrix is factorised anew
constexpr int kMinRounds = 3;         // before the number of rounds is predicted
// Without a factor a round costs a thirtieth for 2000 pins, and shows the error of kErrorDelay rounds ago.
constexpr std::size_t kMaxPlainRounds = 200;
constexpr std::size_t kErrorDelay = 10;

// At a pin the gradients of the representers of E and E' have the product 75 <E, E'> for antisymmetric ones, 45 for
// symmetric ones. A unit of a turn's unknowns is a rotation by sqrt(75 / 2), or sqrt(45) times a matrix of norm 1.
constexpr double kRotationUnit = 6.123724356957945246;
constexpr double kStrainUnit = 6.708203932499369089;
constexpr double kHalfRoot = 0.707106781186547524;  // 1 / sqrt(2)
constexpr double kSixthRoot = 0.408248290463863016;
constexpr std::size_t kStrains = 5;
constexpr std::size_t kMaxUnknowns = 3 + 3 * kNodesOfTurn;  // of a pin; the last one is always 0

// The nodes of a piece are those of Chebyshev and Lobatto, so that the nodes of a degree are also nodes of twice that
// degree.
constexpr int kNodes = 2 * kMaxPinDegree;  // plus 1
constexpr std::array<double, kNodes / 2 + 1> kCosines{1,
                                                      0.98078528040323044913,
                                                      0.92387953251128675613,
                                                      0.83146961230254523708,
                                                      0.70710678118654752440,
                                                      0.55557023301960222474,
                                                      0.38268343236508977173,
                                                      0.19509032201612826785,
                                                      0};
constexpr double kMinPiece = 1.0 / 4096;
constexpr double kKinkMargin = 1e-6;  // of a piece

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

using Unknowns = std::array<double, kMaxUnknowns>;

// The left sides of a pin's equations for a field at its place.
Unknowns values_of(const Vec3<Dual>& v) {
  const Mat3d gradient{v.x.g, v.y.g, v.z.g};
  const Vec3d curl{v.z.g.y - v.y.g.z, v.x.g.z - v.z.g.x, v.y.g.x - v.x.g.y};
  Unknowns result{v.x.v, v.y.v, v.z.v};
  for (std::size_t i = 0; i < 3; ++i) result[3 + i] = curl[i] / (2 * kRotationUnit);
  for (std::size_t i = 0; i < kStrains; ++i) result[6 + i] = product_of(kStrainBasis[i], gradient) / kStrainUnit;
  return result;
}

// Returns whether a quantity that has fallen from `first` to `now` in `rounds` needs more than kMaxRounds to fall to
// `enough` at this rate.
bool converges_too_slowly(double first, double now, double enough, int rounds) {
  return elementary::log(first / now) * (kMaxRounds - rounds) < elementary::log(now / enough) * rounds;
}

[[noreturn]] void refuse() { throw InvalidInput("pins come too near each other; move them apart, or give fewer"); }

double node(int k) { return k <= kNodes / 2 ? kCosines[static_cast<std::size_t>(k)] : -node(kNodes - k); }

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
  // Adds one piece, or halves it recursively.
  void add(double begin, double end) {
    begin_ = begin;
    end_ = end;
    for (auto& solution : solutions_) solution.reset();
    const Nodes* guess = &solution_at(kNodes / 2, nullptr);
    for (int degree = 1; degree <= kMaxPinDegree; degree *= 2) {
      if (fits(degree, guess)) return;
    }
    const double cut = cut_of(begin, end);
    add(begin, cut);
    add(cut, end);
  }

  // Returns where to cut a piece: at the kink nearest to its middle, or in the middle.
  double cut_of(double begin, double end) const {
    const double middle = 0.5 * (begin + end);
    const double margin = kKinkMargin * (end - begin);
    double cut = end;
    for (const double kink : equations_.kinks()) {
      if (kink > begin + margin && kink < end - margin && std::abs(kink - middle) < std::abs(cut - middle)) cut = kink;
    }
    if (cut < end) return cut;
    if (end - begin > kMinPiece) return middle;
    throw InvalidInput(fmt::format(
        "pins come too near each other about the time {:.4g}, or one moves too far for the radius; move them "
        "apart, or less far, or make \"radius\" larger",
        middle));
  }

  // Adds the polynomial of the degree if it is accurate at the further nodes of twice the degree.
  bool fits(int degree, const Nodes* guess) {
    const int stride = kNodes / degree;
    for (int k = 0; k <= kNodes; k += stride) solution_at(k, guess);
    PinPiece piece = interpolated(degree);
    Nodes there(equations_.size());
    for (int k = stride / 2; k <= kNodes; k += stride) {
      for (std::size_t i = 0; i < there.size(); ++i) there[i] = piece.at(i, time_of(k));
      const Nodes& solution = solution_at(k, &there);
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

  const Nodes& solution_at(int k, const Nodes* guess) {
    std::optional<Nodes>& solution = solutions_[static_cast<std::size_t>(k)];
    if (solution) return *solution;
    stop_if_cancelled(progress_);
    equations_.set_time(time_of(k));
    Nodes a = guess != nullptr ? *guess : Nodes(equations_.size());
    equations_.solve(a);
    return solution.emplace(std::move(a));
  }

  // Newton's form of the polynomial through the solutions at the nodes of the degree, in powers of s.
  PinPiece interpolated(int degree) const {
    PinPiece piece{begin_, end_, degree, {}};
    const int stride = kNodes / degree;
    std::array<Vec3d, kMaxPinDegree + 1> f;
    std::array<Vec3d, kMaxPinDegree + 1> powers;
    const auto at = [](int i) { return static_cast<std::size_t>(i); };
    for (std::size_t node_number = 0; node_number < equations_.size(); ++node_number) {
      for (int k = 0; k <= degree; ++k) f[at(k)] = (*solutions_[at(k * stride)])[node_number];
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
  std::array<std::optional<Nodes>, kNodes + 1> solutions_;  // of the current piece
  std::vector<PinPiece> pieces_;
};

// Adds the fields of a turn about a pin at its current place.
void add_turn(const TurnKernel& turn, Field pin, std::vector<Field>& fields) {
  const double radius = pin.thresholds.outer;
  const double rate = norm(turn.rate);
  const Vec3d axis = rate > 0 ? turn.rate / rate : Vec3d{0, 0, 1};
  pin.motion = Rotation<double>{axis, rate / radius, 0, RotationGauge::radial};
  pin.thresholds.falloff = kPinRotationFalloff;
  fields.push_back(pin);
  pin.motion = Strain<double>{turn.strain * (1 / radius)};
  pin.thresholds.falloff = kPinStrainFalloff;
  fields.push_back(std::move(pin));
}

}  // namespace

// The factorised matrix, its nodes in an order with little fill.
struct PinEquations::Factor {
  // A block below the diagonal of a node's three columns: its row of blocks, and its coupling.
  struct Block {
    int row = 0;
    std::size_t coupling = 0;
    bool is_transposed = false;
  };

  std::vector<int> place;                   // of each node in that order
  std::vector<std::vector<Block>> columns;  // by place; by ascending row
  SparseCholesky cholesky;
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
  error_ = std::max(kPinShare * tolerance, kMinError / kSolveShare * speed);
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

// Couples every node of one pin with every node of the other, in the order of set_time().
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
    std::array<Unknowns, kMaxUnknowns> values{};  // by column
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

// Conjugate gradients without a factor until they are first too slow; then preconditioned by the last factorised
// matrix, which is replaced by the current one when they are too slow again. An error e causes an error of v of at most
// sqrt(e.Me), by the norm that the kernels reproduce; this bound ends the rounds.
void PinEquations::solve(Nodes& a) {
  const bool has_factor = !factor_->place.empty();
  if (has_factor ? improve(a) : improve_without_factor(a)) return;
  factorise();
  if (!improve(a)) refuse();
}

double PinEquations::error_of(const Nodes& a, const Nodes& solution) const {
  Nodes e = a;
  for (std::size_t i = 0; i < e.size(); ++i) e[i] -= solution[i];
  return std::sqrt(std::max(dot_of(e, product(e)), 0.0));
}

// Finds the order and the blocks, which do not depend on the time.
void PinEquations::arrange() {
  const auto nodes = static_cast<int>(size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(2 * couplings_.size() + size());
  for (int node = 0; node < nodes; ++node) entries.emplace_back(node, node, 1.0);
  for (const auto& [first, second] : couplings_) {
    entries.emplace_back(static_cast<int>(first), static_cast<int>(second), 1.0);
    entries.emplace_back(static_cast<int>(second), static_cast<int>(first), 1.0);
  }
  Eigen::SparseMatrix<double> graph(nodes, nodes);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>{}(graph, order);
  factor_->place.resize(size());
  for (int at = 0; at < nodes; ++at) factor_->place[static_cast<std::size_t>(order.indices()[at])] = at;
  factor_->columns.resize(size());
  for (std::size_t k = 0; k < couplings_.size(); ++k) {
    const int first = factor_->place[couplings_[k].first];
    const int second = factor_->place[couplings_[k].second];
    factor_->columns[static_cast<std::size_t>(std::min(first, second))].push_back(
        {std::max(first, second), k, first < second});
  }
  for (auto& column : factor_->columns)
    std::sort(column.begin(), column.end(), [](const auto& a, const auto& b) { return a.row < b.row; });
}

void PinEquations::factorise() {
  if (factor_->place.empty()) arrange();
  SymmetricMatrix matrix;
  for (std::size_t at = 0; at < size(); ++at) {
    for (int c = 0; c < 3; ++c) {
      for (int r = c; r < 3; ++r) {
        matrix.rows.push_back(3 * static_cast<int>(at) + r);
        matrix.values.push_back(r == c ? 1 : 0);
      }
      for (const Factor::Block& block : factor_->columns[at]) {
        const Mat3d& values = blocks_[block.coupling];
        for (int r = 0; r < 3; ++r) {
          const auto [row, column] = block.is_transposed ? std::pair(c, r) : std::pair(r, c);
          matrix.rows.push_back(3 * block.row + r);
          matrix.values.push_back(values.column(static_cast<std::size_t>(column))[static_cast<std::size_t>(row)]);
        }
      }
      matrix.begin.push_back(matrix.rows.size());
    }
  }
  if (!factor_->cholesky.factorize(matrix)) refuse();
}

Nodes PinEquations::by_factor(const Nodes& right) const {
  std::vector<double> numbers(3 * right.size());
  for (std::size_t i = 0; i < right.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) numbers[3 * static_cast<std::size_t>(factor_->place[i]) + k] = right[i][k];
  }
  factor_->cholesky.solve(numbers);
  Nodes result(right.size());
  for (std::size_t i = 0; i < right.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) result[i][k] = numbers[3 * static_cast<std::size_t>(factor_->place[i]) + k];
  }
  return result;
}

Nodes PinEquations::residual(const Nodes& a) const {
  Nodes rest = right_;
  const Nodes there = product(a);
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= there[i];
  return rest;
}

// Returns whether `a` has become the solution. In each round e.Me falls by the step times the square of the residual
// (Hestenes and Stiefel). The sum of the last falls is nearly the e.Me before them.
bool PinEquations::improve_without_factor(Nodes& a) const {
  Nodes rest = residual(a);
  Nodes direction = rest;
  double square = dot_of(rest, rest);
  std::array<double, kErrorDelay> falls{};
  const double enough = kSolveShare * error_;
  for (std::size_t round = 0; round < kMaxPlainRounds; ++round) {
    if (square == 0) return true;
    const Nodes image = product(direction);
    const double step = square / dot_of(direction, image);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      a[i] += direction[i] * step;
      rest[i] -= image[i] * step;
    }
    falls[round % kErrorDelay] = step * square;
    if (round + 1 >= kErrorDelay && std::accumulate(falls.begin(), falls.end(), 0.0) <= enough * enough) return true;
    const double last = std::exchange(square, dot_of(rest, rest));
    for (std::size_t i = 0; i < rest.size(); ++i) direction[i] = rest[i] + direction[i] * (square / last);
  }
  return false;
}

// The same with the factor, whose product with the residual estimates e.Me.
bool PinEquations::improve(Nodes& a) const {
  Nodes rest = residual(a);
  Nodes direction;
  double first = 0;
  double last = 0;
  const double enough = kSolveShare * error_;
  for (int round = 0; round < kMaxRounds; ++round) {
    const Nodes better = by_factor(rest);
    const double now = dot_of(rest, better);
    if (now <= enough * enough) return true;
    if (round == 0) first = now;
    if (round >= kMinRounds && converges_too_slowly(first, now, enough * enough, round)) return false;
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

Vec3d PinPiece::at(std::size_t node, double t) const {
  const double s = (2 * t - begin - end) / (end - begin);
  const Vec3d* const of_node = coefficients.data() + node * (static_cast<std::size_t>(degree) + 1);
  Vec3d value = of_node[degree];
  for (int power = degree - 1; power >= 0; --power) value = of_node[power] + value * s;
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
  std::size_t node = segment.fields.size();
  for (const PinTurn& turn : segment.turns) {
    std::array<Vec3d, kNodesOfTurn> nodes;
    for (Vec3d& of_turn : nodes) of_turn = piece->at(node++, t);
    add_turn(turn_kernel(nodes), fields[turn.pin], fields);
  }
  return fields;
}

}  // namespace knead::detail
