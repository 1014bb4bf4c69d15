// The velocities with which the fields of a pinned segment are summed (method, section 9). Internal to the flow room.
//
// At the time t the pins are at q_i(t) = c_i + t u_i, and the a_j(t) solve sum_j Psi((q_i - q_j) / R) a_j = u_i, R
// being the pins' radius and Psi a the velocity of a pin that moves with a. They are kept as polynomials.
#pragma once

#include <cstddef>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/math/progress.h"

namespace knead::detail {

inline constexpr int kMostPinDegree = 8;

// The solution over a part of the segment's time, in powers of s = (2 t - begin - end) / (end - begin): of each pin
// a_i(t), then of each turn its three nodes (pin_equations.h).
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

// Returns the pieces of a pinned segment from its begin to its end, in ascending time whatever its direction. With them
// v errs nowhere by more than kPinShare * tolerance at the times at which they were compared with a solution. The
// segment is valid; no time, no pieces; none either where progress->cancel is set. Throws InvalidInput where pins come
// so near each other that the equations cannot be solved. Time: for n pins of which each has k others in its reach
// about n k^2, for each of 5 to 17 times of a piece.
std::vector<PinPiece> solve_pins(const Segment& segment, double tolerance, const Progress* progress = nullptr);

// Returns the fields whose sum is v at the time t, as resting fields: the pins are where they are then, with the
// velocities a; after them a rotation and a strain for each turn. Beyond the pieces' ends the nearest one is used.
std::vector<Field> fields_at(const Segment& segment, const std::vector<PinPiece>& pieces, double t);

}  // namespace knead::detail
