// Rigid maps, and moving a shape as a whole to where it is fitted from. Internal to the fit module.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fit/surface_matches.h"
#include "knead/fit.h"
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

// Throws InvalidInput for options that cannot be used, whatever the shapes are.
void require_usable(const BodyFitOptions& options);

// Throws InvalidInput for landmarks that would tear the shape: two that start at one point, or end at one.
void require_apart(std::span<const FitPair> landmarks, double diagonal);

// Throws InvalidInput where the places of the pairs are the mirror image of their points.
void require_no_mirror(std::span<const FitPair> pairs, double diagonal);

// Throws InvalidInput where boxes of the shapes lie so far apart that their surfaces cannot find each other.
void require_near(const Box& source, const Box& target);

// Returns the rigid map that brings the pairs together; pairs that disagree with the others count little. Nothing for
// fewer than three.
std::optional<RigidMap> align_pairs(std::span<const FitPair> pairs);

// How well two surfaces lie upon each other.
struct SurfaceAlignment {
  RigidMap map;
  double distance = 0;         // the mean of points and normals after it
  double distance_before = 0;  // the same before it
};

// Tries the surfaces as they are, the four ways in which their principal axes can point, and those of the boxes'
// centres, each followed by matching nearest points, and returns the best. Samples: 100 or more of each surface.
SurfaceAlignment align_surfaces(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& target,
                                double diagonal);

// A growth of the whole shape: x goes to to + (x - from) * factor.
struct Growth {
  double factor = 1;
  Vec3d from;
  Vec3d to;

  Vec3d operator()(const Vec3d& x) const { return to + (x - from) * factor; }
};

// Returns the growth that brings the surfaces together, from factors of 1, of their sizes and of `by_volume` on, each
// followed by matching nearest points; nothing where that does not bring them nearer. Samples as above.
std::optional<Growth> growth_of(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& target,
                                double by_volume, double diagonal);

// Returns the growth that brings the pairs together; nothing for fewer than three, and where they are not nearer.
std::optional<Growth> growth_of(std::span<const FitPair> pairs);

// Returns strokes that move what is within `radius` of `center` by the map: a rotation about the centre, and a
// translation.
std::vector<Stroke> strokes_of(const RigidMap& map, const Vec3d& center, double radius);

}  // namespace knead::fit_detail
