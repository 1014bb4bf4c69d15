// The equations of pins at any time (method, section 9). Internal to the flow room.
//
// A pin that also turns prescribes the gradient of v at its place: that of a rotation with its rate. Its kernels are
// the derivatives of Psi: one for each traceless matrix E, the Riesz representer of the functional <E, grad v>. They
// are fields of a ball: a rotation for an antisymmetric E, a strain for a symmetric one.
//
// Unknowns come in vectors of three, the nodes: one for each pin, its velocity a; then three for each turn, the second
// and third its strain. Each unknown has the norm 1 by which the kernels reproduce values, so a node's own block is the
// identity.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/math/mat3.h"

namespace knead::detail {

// The parts of the tolerance that v may err by in all, and that solutions may.
inline constexpr double kPinShare = 0.1;
inline constexpr std::size_t kNodesOfTurn = 3;

// Psi at y, in radii: what a pin that moves by a makes of it there is Psi a. Zero from a radius on.
inline Mat3d pin_kernel(const Vec3d& y) {
  const double r = norm(y);
  const double rest = std::max(1 - r, 0.0);
  const double fourth = (rest * rest) * (rest * rest);
  return Mat3d{} * (fourth * (1 + 4 * r - 20 * (r * r))) + outer_product(y, y) * (15 * fourth);
}

// What the nodes of a turn add to v near its pin: rate x y and strain y, each with its weight; y in radii.
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

  // How many nodes there are.
  std::size_t size() const { return right_.size(); }

  // The times, ascending, at which a pin that turns and another one come into each other's reach or leave it. There the
  // solution has a jump in its second derivative.
  const std::vector<double>& kinks() const { return kinks_; }

  // The greatest error that v may have, anywhere.
  double error() const { return error_; }

  // Makes t the time of what follows.
  void set_time(double t);

  // Makes `a`, a guess, the solution. Throws InvalidInput where the pins come too near each other.
  void solve(Nodes& a);

  // Returns a bound for the error of v with `a`, given the solution.
  double error_of(const Nodes& a, const Nodes& solution) const;

 private:
  struct Factor;

  // Two pins that are in each other's reach at some time.
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
  void factorise();
  Nodes by_factor(const Nodes& right) const;
  bool improve_without_factor(Nodes& a) const;
  bool improve(Nodes& a) const;

  double radius_;
  double error_ = 0;
  std::vector<Vec3d> places_;  // at t = 0
  std::vector<Vec3d> motions_;
  std::vector<std::uint32_t> turn_nodes_;  // the first node of each pin's turn; 0: it has none
  Nodes right_;
  std::vector<Pair> pairs_;
  std::vector<double> kinks_;
  std::vector<Coupling> couplings_;  // of the pairs in turn
  std::vector<Mat3d> blocks_;        // of the couplings, at the time: rows of the first node, columns of the second
  std::unique_ptr<Factor> factor_;
};

}  // namespace knead::detail
