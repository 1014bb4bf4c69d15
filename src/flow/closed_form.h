// Path lines that need no integration (method, section 3, "Exact facts"), the time at which a tool reaches a point, and
// one field in the scalar of the evaluation. Internal to the library.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "field/mask_grid.h"
#include "knead/flow.h"

namespace knead {

// Returns the displacement of the point x from segment.begin to segment.end if it is known in closed form. Ignores the
// segment's limit cylinder. Known are
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

// Returns the earliest time, from t towards segment.end, at which the resting point x can be inside the support
// (r < outer) of a field of the segment; t if it is inside already; nothing if it never is. Exact for balls and
// capsules (the root of a quadratic). A lower bound for other regions: the tool then has at most 1e-4 (outer - inner)
// left to move.
std::optional<double> next_contact(const Segment& segment, const Vec3d& x, double t);

}  // namespace knead

namespace knead::detail {

// |dr/dt| at a resting point, caused by the region's turning.
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

// The length over which r passes from one threshold to the other if that depends on the place: between handles, the
// distance from one set past d to the other. Infinity if the thresholds are lengths.
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

// One field with its numbers in the scalar S, for a point at x0 + moved, which started at x0.
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

  // The same between handles, and the width there: both need the distances from all points.
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

  // The speed at which r may change apart from the point's motion relative to the tool: by turning, or by the field of
  // a blended segment whose weight is still small.
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
