// Rigid maps and growths of a whole shape, with which a fit begins. Internal to the fit module.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fit/surface_matches.h"
#include "knead/fit.h"
#include "knead/vec.h"
#include "math/geometry.h"

namespace knead::detail {

// Returns approximately the given part, from 0 to 1, of a turn by less than 180 degrees; exactly for 0 and 1.
Quaternion part_of(const Quaternion& turn, double part);
// Returns the rotation that takes `from` nearest to `to`, given the sum of w_i to_i from_i^T (Horn 1987). Never a
// mirror image.
Quaternion nearest_turn(const Mat3d& sum);

// p -> turn * (p - from) + to.
struct RigidMap {
  Quaternion turn{};
  Vec3d from{0, 0, 0};
  Vec3d to{0, 0, 0};

  Vec3d operator()(const Vec3d& p) const { return turn * (p - from) + to; }
};

// Returns the rigid map that takes points nearest to their targets, by weighted least squares. The lists have the same
// number of items, one at least. Weights are above 0; empty: all 1.
RigidMap nearest_rigid(std::span<const Vec3d> from, std::span<const Vec3d> to, std::span<const double> weights = {});

// Returns the root mean square of the remaining distances.
double rms_of(const RigidMap& map, std::span<const Vec3d> from, std::span<const Vec3d> to);

// Throws InvalidInput with this text unless a condition holds.
void require(bool holds, const std::string& what);

// Throws InvalidInput for options out of range.
void require_usable(const BodyFitOptions& options);

// Throws InvalidInput for landmarks that would tear the shape: two that start at one point, or end at one.
void require_apart(std::span<const FitPair> landmarks, double diagonal);

// Throws InvalidInput if the targets of the pairs are the mirror image of their sources.
void require_no_mirror(std::span<const FitPair> pairs, double diagonal);

// Throws InvalidInput if the boxes of the shapes are too far apart for matching surfaces.
void require_near(const Box& source, const Box& target);

// Returns the rigid map that brings the pairs together; pairs that disagree with the others have little weight. Returns
// nothing for fewer than three pairs.
std::optional<RigidMap> align_pairs(std::span<const FitPair> pairs);

// The best rigid alignment of two surfaces.
struct SurfaceAlignment {
  RigidMap map;
  double distance = 0;         // the mean of points and normals after it
  double distance_before = 0;  // the same before it
};

// Returns the best alignment from these starts, each followed by iterated closest points: none, equal centres, and the
// four directions of the principal axes. Samples: 100 or more of each surface.
SurfaceAlignment align_surfaces(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& target,
                                double diagonal);

// A growth of the whole shape: maps x to to + (x - from) * factor.
struct Growth {
  double factor = 1;
  Vec3d from;
  Vec3d to;

  Vec3d operator()(const Vec3d& x) const { return to + (x - from) * factor; }
};

// Returns the best growth from three starts, each followed by iterated closest points: the factors 1, `by_volume` and
// the ratio of the sizes. Returns nothing if none brings the surfaces nearer. Samples as above.
std::optional<Growth> growth_of(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& target,
                                double by_volume, double diagonal);

// Returns the growth that brings the pairs together; nothing for fewer than three, or if it does not bring them nearer.
std::optional<Growth> growth_of(std::span<const FitPair> pairs);

// Returns strokes that move everything within `radius` of `center` by the map: a rotation about the centre, and a
// translation.
std::vector<Stroke> strokes_of(const RigidMap& map, const Vec3d& center, double radius);

}  // namespace knead::detail
