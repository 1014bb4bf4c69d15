// Rotations as quaternions, and the rigid map that is nearest to given motions. Internal to the fit module.
#pragma once

#include <span>

#include "knead/vec.h"

namespace knead::fit_detail {

// A rotation: a unit quaternion.
struct Turn {
  double w = 1;
  Vec3d v{0, 0, 0};  // the axis times the sine of half the angle
};

// Returns a after b.
Turn operator*(const Turn& a, const Turn& b);
// Returns the turn back.
inline Turn inverse(const Turn& turn) { return {turn.w, -turn.v}; }
// Returns the turned vector.
Vec3d operator*(const Turn& turn, const Vec3d& p);
// Returns the part of a turn by less than 180 degrees; part 0: none, 1: all of it. About right in between.
Turn part_of(const Turn& turn, double part);
// Returns the greatest eigenvalue's unit vector of the quaternions' matrix for sum = sum of w_i to_i from_i^T: the
// rotation that takes `from` nearest to `to`. Never a mirror image.
Turn nearest_turn(const Mat3d& sum);

// p -> turn * (p - from) + to.
struct RigidMap {
  Turn turn{};
  Vec3d from{0, 0, 0};
  Vec3d to{0, 0, 0};

  Vec3d operator()(const Vec3d& p) const { return turn * (p - from) + to; }
};

// Returns the rigid map that takes points nearest to their places, by weighted least squares. There is at least one
// point, as many of each list, and weights above 0; empty: all 1.
RigidMap nearest_rigid(std::span<const Vec3d> from, std::span<const Vec3d> to, std::span<const double> weights = {});

// Returns the root mean square of the distances that are left.
double rms_of(const RigidMap& map, std::span<const Vec3d> from, std::span<const Vec3d> to);

}  // namespace knead::fit_detail
