// Curves and lattices as one kind of segment.
#include "flow/segment_map.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "flow/masked.h"
#include "knead/error.h"

namespace knead::detail {
namespace {

std::variant<CurveMap, LatticeMap> map_of(const Segment& segment) {
  const bool is_curve = !segment.curve.is_empty();
  if (mask_on(segment).acts) {
    throw InvalidInput(
        is_curve ? "a curve takes everything about it along, so a mask cannot hold a part of that; remove the mask "
                   "before this stroke, or give \"radius\""
                 : "a lattice with the mode \"spline\" moves everything in its box, so a mask cannot hold a part of "
                   "that; remove the mask before this stroke, or take the mode \"volume\"");
  }
  if (is_curve) return CurveMap(segment);
  return LatticeMap(segment);
}

}  // namespace

SegmentMap::SegmentMap(const Segment& segment) : map_(map_of(segment)) {}

SegmentMap::Status SegmentMap::move(Vec3d& x) const {
  if (const LatticeMap* const map = lattice()) return map->move(x) ? Status::moved : Status::rests;
  return std::get<CurveMap>(map_).move(x);
}

SegmentMap::Status SegmentMap::move(Vec3d& x, Mat3d& jacobian) const {
  if (const LatticeMap* const map = lattice()) return map->move(x, jacobian) ? Status::moved : Status::rests;
  return std::get<CurveMap>(map_).move(x, jacobian);
}

SegmentMover map_mover(const Segment& segment) {
  const auto map = std::make_shared<const SegmentMap>(segment);
  return [map](const LiveGroup& group) {
    GroupCounts counts;
    for (int k = 0; k < group.block_count; ++k) {
      const std::size_t block = group.blocks[k];
      for (std::uint64_t rest = group.members[block]; rest != 0; rest &= rest - 1) {
        const std::size_t i = block * kBlock + static_cast<std::size_t>(__builtin_ctzll(rest));
        const Vec3d from{group.points.x[i], group.points.y[i], group.points.z[i]};
        Vec3d x = from;
        const SegmentMap::Status status = map->move(x);
        ++counts.evaluations;
        if (status == SegmentMap::Status::impossible) counts.complete = false;
        if (status != SegmentMap::Status::moved) continue;
        ++counts.accepted;
        ++group.steps[i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          group.moved[block] = std::max(group.moved[block], std::abs(x[axis] - from[axis]));
        }
        group.points.x[i] = x.x;
        group.points.y[i] = x.y;
        group.points.z[i] = x.z;
      }
    }
    return counts;
  };
}

std::vector<Vec3d> map_velocities(const Segment& segment, std::span<const Vec3d> points, double t) {
  if (!segment.curve.is_empty()) return curve_velocities(segment.curve, points, t);
  Segment from = segment;
  from.begin = t;
  const LatticeMap map(from);
  std::vector<Vec3d> result;
  result.reserve(points.size());
  for (const Vec3d& x : points) result.push_back(map.velocity(x));
  return result;
}

}  // namespace knead::detail
