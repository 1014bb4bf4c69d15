// Pins (method, section 9): their equations at a time, their velocities as polynomials of the time, and the numbers
// that kernels read. Internal to the library.
//
// A pin that also turns prescribes the gradient of v at its place: that of a rotation with its rate. Its kernels are
// the derivatives of Psi: one for each traceless matrix E, the Riesz representer of the functional <E, grad v>. They
// are fields of a ball: a rotation for an antisymmetric E, a strain for a symmetric one.
//
// Unknowns come in vectors of three, the nodes: first the velocity a of each pin, then for each turn its rotation and
// two nodes of its strain. Each unknown has norm 1 in the norm that the kernels reproduce, so a node's own block is the
// identity.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "flow/kernels/kernel.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

inline constexpr double kPinShare = 0.1;  // of the tolerance: the error of v
inline constexpr std::size_t kNodesOfTurn = 3;

// Psi at y, in radii: a pin that moves with a has the velocity Psi a at y. Zero beyond a radius.
inline Mat3d pin_kernel(const Vec3d& y) {
  const double r = norm(y);
  const double rest = std::max(1 - r, 0.0);
  const double fourth = (rest * rest) * (rest * rest);
  return Mat3d{} * (fourth * (1 + 4 * r - 20 * (r * r))) + outer_product(y, y) * (15 * fourth);
}

// The contribution of a turn's nodes to v near its pin: rate x y and strain y, each with its weight; y in radii.
struct TurnKernel {
  Vec3d rate;
  Mat3d strain;
};
TurnKernel turn_kernel(std::span<const Vec3d, kNodesOfTurn> nodes);

using Nodes = std::vector<Vec3d>;

// The pins of a valid segment.
class PinEquations {
 public:
  PinEquations(const Segment& segment, double tolerance);
  PinEquations(const PinEquations&) = delete;
  PinEquations& operator=(const PinEquations&) = delete;
  ~PinEquations();

  // The number of nodes.
  std::size_t size() const { return right_.size(); }

  // The ascending times at which a turning pin and another one come within a radius, or apart. There the second
  // derivative of the solution jumps.
  const std::vector<double>& kinks() const { return kinks_; }

  // The error that v may have anywhere.
  double error() const { return error_; }

  // Sets the time of the equations.
  void set_time(double t);

  // Replaces the guess `a` by the solution. Throws InvalidInput if the pins come too near each other.
  void solve(Nodes& a);

  // Returns a bound for the error of v with `a`, given the solution.
  double error_of(const Nodes& a, const Nodes& solution) const;

 private:
  struct Factor;

  // Two pins that are within a radius at some time.
  struct Pair {
    std::uint32_t first = 0;
    std::uint32_t second = 0;
  };
  // Two different nodes of a pair, first < second.
  struct Coupling {
    std::uint32_t first = 0;
    std::uint32_t second = 0;
  };

  void find_pairs(double begin, double end);
  void add_couplings(const Pair& pair);
  void add_kinks(const Pair& pair, double begin, double end);
  Nodes product(const Nodes& a) const;
  Nodes residual(const Nodes& a) const;
  void arrange();
  void factorise();
  Nodes by_factor(const Nodes& right) const;
  bool improve_without_factor(Nodes& a) const;
  bool improve(Nodes& a) const;

  double radius_;
  double error_ = 0;
  std::vector<Vec3d> places_;  // at t = 0
  std::vector<Vec3d> motions_;
  std::vector<std::uint32_t> turn_nodes_;  // the first node of each pin's turn; 0: none
  Nodes right_;
  std::vector<Pair> pairs_;
  std::vector<double> kinks_;
  std::vector<Coupling> couplings_;  // of the pairs in turn
  std::vector<Mat3d> blocks_;        // of the couplings, at the time: rows of the first node, columns of the second
  std::unique_ptr<Factor> factor_;
};

inline constexpr int kMaxPinDegree = 8;

// The solution over a part of the segment's time, as polynomials in s = (2 t - begin - end) / (end - begin): a_i(t) of
// each pin, then the three nodes of each turn. The a_j(t) solve sum_j Psi((q_i - q_j) / R) a_j = u_i, where the pins
// are at q_i(t) = c_i + t u_i and R is their radius.
struct PinPiece {
  double begin = 0;
  double end = 1;
  int degree = 0;
  std::vector<Vec3d> coefficients;  // degree + 1 of each node, the constant first

  const Vec3d& power(std::size_t node, std::size_t exponent) const {
    return coefficients[node * (static_cast<std::size_t>(degree) + 1) + exponent];
  }
  Vec3d at(std::size_t node, double t) const;
};

// Returns the pieces of a valid pinned segment from its begin to its end, in ascending time for either direction; none
// if these are the same, or if progress->cancel is set. v errs by at most kPinShare * tolerance at the times at which
// the pieces were compared with a solution. Throws InvalidInput if pins come so near each other that the equations
// cannot be solved. Time: about n k^2 for n pins with k others within a radius each, for each of 5 to 17 times of a
// piece.
std::vector<PinPiece> solve_pins(const Segment& segment, double tolerance, const Progress* progress = nullptr);

// Returns the fields whose sum is v at the time t, at rest: the pins at their places with the velocities a, then a
// rotation and a strain for each turn. Beyond the pieces' ends the nearest piece is used.
std::vector<Field> fields_at(const Segment& segment, const std::vector<PinPiece>& pieces, double t);

// The numbers of one piece's pins, relative to a centre, and the kernel's field that points to them (kernel_pins.h).
template <class S>
struct OwnedPins {
  PinKernelField<S> field;
  std::vector<S> numbers;
  std::vector<S> turn_numbers;
  std::vector<ExactPin> exact;

  OwnedPins(const Segment& segment, const PinPiece& piece, const Vec3d& center, bool masked) {
    field.center = center;
    field.radius = segment.fields.front().thresholds.outer;
    field.degree = piece.degree;
    for (std::size_t i = 0; i < segment.fields.size(); ++i) add_pin(segment, piece, i);
    for (std::size_t i = 0; i < segment.turns.size(); ++i) add_turn(segment, piece, i);
    field.pins = {numbers.data(), static_cast<int>(exact.size()), 9 + 3 * piece.degree};
    field.turns = {turn_numbers.data(), static_cast<int>(segment.turns.size()), 15 + 9 * piece.degree};
    field.exact = exact.data();
    field.per_radius = static_cast<S>(1 / field.radius);
    field.middle = static_cast<S>(0.5 * (piece.begin + piece.end));
    field.per_half = static_cast<S>(2 / (piece.end - piece.begin));
    field.begin = segment.begin;
    field.end = segment.end;
    if (masked) field.mask = view_of<S>(segment.mask, field.center);
  }
  OwnedPins(const OwnedPins&) = delete;
  OwnedPins& operator=(const OwnedPins&) = delete;
  ~OwnedPins() = default;

 private:
  static void add(const Vec3d& v, std::vector<S>& list) {
    for (std::size_t axis = 0; axis < 3; ++axis) list.push_back(static_cast<S>(v[axis]));
  }

  void add_pin(const Segment& segment, const PinPiece& piece, std::size_t i) {
    const Vec3d place = segment.fields[i].center - field.center;
    const Vec3d by = displacement_of(segment, segment.fields[i]);
    add(place / field.radius, numbers);
    add(by / field.radius, numbers);
    for (std::size_t k = 0; k <= static_cast<std::size_t>(piece.degree); ++k) add(piece.power(i, k), numbers);
    exact.push_back({place, by, norm(by)});
  }

  void add_turn(const Segment& segment, const PinPiece& piece, std::size_t i) {
    const ExactPin& pin = exact[segment.turns[i].pin];
    add(pin.place / field.radius, turn_numbers);
    add(pin.by / field.radius, turn_numbers);
    const std::size_t node = segment.fields.size() + kNodesOfTurn * i;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(piece.degree); ++k) {
      const TurnKernel turn =
          turn_kernel(std::array{piece.power(node, k), piece.power(node + 1, k), piece.power(node + 2, k)});
      add(turn.rate, turn_numbers);
      add({turn.strain.row0.x, turn.strain.row1.y, turn.strain.row2.z}, turn_numbers);
      add({turn.strain.row0.y, turn.strain.row0.z, turn.strain.row1.z}, turn_numbers);
    }
  }
};

}  // namespace knead::detail
