// Moving a shape as a whole to where it is fitted from. Internal to the fit module.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fit/rigid_map.h"
#include "fit/surface_matches.h"
#include "knead/fit.h"

namespace knead::fit_detail {

// Throws InvalidInput for options that cannot be used, whatever the shapes are.
void require_usable(const BodyFitOptions& options);

// Throws InvalidInput for landmarks that would tear the shape: two that start at one point, or end at one.
void require_apart(std::span<const FitPair> landmarks, double diagonal);

// Throws InvalidInput where the places of the pairs are the mirror image of their points.
void require_no_mirror(std::span<const FitPair> pairs, double diagonal);

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
