// Path lines that need no integration (method, section 3, "Exact facts").
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "field/mask_grid.h"
#include "knead/flow.h"

namespace knead {

// Returns the displacement of the point x from segment.begin to segment.end where it is known in closed form, else
// nothing. The segment's limit cylinder is ignored. Known are
//   - a translation swept along with its tool, for a point of the rigid inner region: the tool's displacement, exactly;
//   - a rotation in a ball about its centre, and a twist whose half-space's normal is parallel to its axis: every point
//     turns about the axis at a constant rate;
//   - the points of handles: those of the zero set rest, those of the full set follow the motion, exactly;
//   - a rotation, twist or symmetric strain, for points that stay in the inner region.
std::optional<Vec3d> closed_form(const Segment& segment, const Vec3d& x);

// The points of a segment's handles, sorted: the same answers for many x, each in the time of a binary search.
class HandlePoints {
 public:
  explicit HandlePoints(const Segment& segment);

  // Returns whether the segment has handles, and no other field.
  bool are_all() const { return !full_.empty(); }

  // Returns closed_form(segment, x) for the same segment, which must have handles alone.
  std::optional<Vec3d> closed_form(const Segment& segment, const Vec3d& x) const;

 private:
  std::vector<Vec3d> full_;
  std::vector<Vec3d> zero_;
};

// When a moving tool reaches a resting point.

// Returns the earliest time, from t towards segment.end, at which the resting point x can be inside the support
// (r < outer) of a field of the segment; t if it is inside already; nothing if it never is. Exact for balls and
// capsules (the root of a quadratic). For other regions a lower bound: the tool then still has at most 1e-4 (outer -
// inner) to move.
std::optional<double> next_contact(const Segment& segment, const Vec3d& x, double t);

}  // namespace knead

// One field with its numbers in the scalar of the evaluation.
namespace knead::detail {

// |dr/dt| at a resting point: how fast a region turns past it.
template <class S>
S turning_speed(const HalfSpace<S>& region, const Vec3<S>& d, double t) {
  if (region.turn_angle == S(0)) return S(0);
  const Vec3<S> n = normal_at(region, static_cast<S>(t));
  return std::abs(region.turn_angle * dot(cross(region.turn_axis, n), d));
}

template <class S, class Set>
S turning_speed(const Handles<S, Set>& region, const Vec3<S>& d, double /*t*/) {
  return std::abs(region.turn_angle) * norm(cross(region.turn_axis, d));
}

template <class S>
S turning_speed(const CustomRegion& region, const Vec3<S>& /*d*/, double /*t*/) {
  return static_cast<S>(region.speed);
}

template <class S>
S turning_speed(const auto& /*region*/, const Vec3<S>& /*d*/, double /*t*/) {
  return S(0);
}

// The length over which r passes from one threshold to the other, where that depends on the place: between handles, the
// distance from one set past d to the other. Infinity where the thresholds are themselves lengths.
template <class S>
S width_between(const HandlesDistances<S>& distance) {
  return distance.full.value + distance.zero.value;
}

template <class S, class Set>
S local_width(const Handles<S, Set>& region, const Vec3<S>& d, double t) {
  return width_between(handles_distances(region, d, static_cast<S>(t)));
}

template <class S>
S local_width(const auto& /*region*/, const Vec3<S>& /*d*/, double /*t*/) {
  return std::numeric_limits<S>::infinity();
}

template <class R>
inline constexpr bool kHasWidth = false;
template <class S, class Set>
inline constexpr bool kHasWidth<Handles<S, Set>> = true;

// The point that started at x0 and has moved by D is at x0 + D.
template <class S, class M, class R>
struct SingleField {
  M motion;
  R region;
  Thresholds<S> thresholds;
  Vec3d center;
  Vec3<S> displacement;
  bool blended = false;
  MaskView<S> mask{};  // empty: none
  Vec3<S> offset{};    // of the potential, under a mask

  Vec3<S> velocity(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    const auto s = static_cast<S>(t);
    const Vec3<S> d = Vec3<S>(x0 - center) + moved;
    if (!mask.is_empty()) return masked_velocity(d, s);
    if (!blended) return knead::velocity(motion, region, thresholds, d - displacement * s, s);
    return knead::velocity(motion, region, thresholds, d, s) * (S(1) - s) +
           knead::velocity(motion, region, thresholds, d - displacement, s) * s;
  }

  // The same between handles, with the width there: both need the distances from all points.
  Vec3<S> velocity_and_width(const Vec3d& x0, const Vec3<S>& moved, double t, S& width_there) const {
    if (blended) {
      width_there = width(x0, moved, t);
      return velocity(x0, moved, t);
    }
    const auto s = static_cast<S>(t);
    const Vec3<S> from = Vec3<S>(x0 - center) + moved;
    const Vec3<S> d = from - displacement * s;
    const HandlesDistances<S> distance = handles_distances(region, d, s);
    width_there = width_between(distance);
    const RegionValue<S> r = region_between(distance);
    if (mask.is_empty()) return velocity_where(r, motion, thresholds, d);
    return masked_velocity_where(r, motion, thresholds, d, evaluate_mask(mask, from), offset);
  }

  Vec3<S> masked_velocity(const Vec3<S>& d, const S& t) const {
    const MaskValue<S> m = evaluate_mask(mask, d);
    const auto at = [&](const Vec3<S>& from, const S& time) {
      return masked_velocity_where(evaluate(region, from, time), motion, thresholds, from, m, offset);
    };
    if (!blended) return at(d - displacement * t, t);
    return at(d, t) * (S(1) - t) + at(d - displacement, t) * t;
  }

  // A speed at which r may change besides that of the point relative to the tool's frame: by turning, or by the part of
  // a blended field whose weight is still small.
  S hidden_speed(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    const Vec3<S> d = Vec3<S>(x0 - center) + moved;
    if (!blended) return turning_speed(region, d - displacement * static_cast<S>(t), t);
    return std::max(norm(knead::velocity(motion, region, thresholds, d, S(0))),
                    norm(knead::velocity(motion, region, thresholds, d - displacement, S(0))));
  }

  S width(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    return local_width(region, Vec3<S>(x0 - center) + moved - displacement * static_cast<S>(t), t);
  }
};

}  // namespace knead::detail
