#include "knead/flow/pins.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "knead/flow/pin_equations.h"
#include "knead/math/error.h"

namespace knead::detail {

namespace {

// Nodes of a piece are those of Chebyshev and Lobatto, so that those of a degree are nodes of twice the degree too.
constexpr int kMostDegree = kMostPinDegree;
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
constexpr double kNoPiece = 1e-6;  // of a piece

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
  // One piece, or two halves of it, and so on.
  void add(double begin, double end) {
    begin_ = begin;
    end_ = end;
    for (auto& solution : solutions_) solution.reset();
    const Nodes* guess = &solution_at(kNodes / 2, nullptr);
    for (int degree = 1; degree <= kMostDegree; degree *= 2) {
      if (fits(degree, guess)) return;
    }
    const double cut = cut_of(begin, end);
    add(begin, cut);
    add(cut, end);
  }

  // Where a piece that does not fit is cut in two: at the kink nearest to the middle, or in the middle.
  double cut_of(double begin, double end) const {
    const double middle = 0.5 * (begin + end);
    const double margin = kNoPiece * (end - begin);
    double cut = end;
    for (const double kink : equations_.kinks()) {
      if (kink > begin + margin && kink < end - margin && std::abs(kink - middle) < std::abs(cut - middle)) cut = kink;
    }
    if (cut < end) return cut;
    if (end - begin > kShortestPiece) return middle;
    throw InvalidInput(fmt::format(
        "pins come too near each other about the time {:.4g}, or one moves too far for the radius; move them "
        "apart, or less far, or make \"radius\" larger",
        middle));
  }

  // Adds the polynomial of the degree if it is right at the nodes that twice the degree has besides.
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
    std::array<Vec3d, kMostDegree + 1> f;
    std::array<Vec3d, kMostDegree + 1> powers;
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
  std::array<std::optional<Nodes>, kNodes + 1> solutions_;  // of the piece in work
  std::vector<PinPiece> pieces_;
};

// Adds the fields of a turn about a pin, which is where it is at the time.
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
