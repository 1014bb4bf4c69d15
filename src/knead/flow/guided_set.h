// A point set with a tree that says how far its points are, about. Internal to the flow room.
#pragma once

#include <cmath>
#include <limits>
#include <memory>

#include "knead/field/packed_set.h"
#include "knead/flow/point_tree.h"

namespace knead::detail {

template <class S>
struct GuidedSet {
  PackedSet<S> set;
  std::shared_ptr<const PointTree> tree;
};

template <class S>
GuidedSet<S> guided(const PointSet<double>& set) {
  return {packed<S>(set), std::make_shared<const PointTree>(set.points)};
}

// r and grad r at d, with the sums measured by the distance to a point that is near, not by the least of all distances:
// half of the time for a large set. Where the sums overflow (a point is far nearer than that one), as PackedSet.
template <class S>
RegionValue<S> evaluate(const GuidedSet<S>& region, const Vec3<S>& d, const S& t) {
  if (!region.set.curves->empty() || region.tree->size() == 0) return evaluate(region.set, d, t);
  S near2 = std::numeric_limits<S>::max();
  region.tree->visit_near(Vec3d(d), [&](const Vec3d& p) { near2 = std::min(near2, norm2(d - Vec3<S>(p))); });
  if (near2 > S(0)) {
    const RegionValue<S> r = evaluate_by(region.set, d, near2, std::sqrt(near2));
    if (is_sound(r)) return r;
  }
  return evaluate(region.set, d, t);
}

}  // namespace knead::detail
