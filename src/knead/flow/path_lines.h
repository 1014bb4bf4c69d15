// Path lines taken one by one, for the fields that have no kernel: large point sets, curves, marked regions, sums,
// blended fields and the caller's own. Internal to the flow room: instantiated in path_lines_float.cpp and
// path_lines_double.cpp.
#pragma once

#include "knead/field/packed_set.h"
#include "knead/flow/path_line.h"
#include "knead/flow/segment_mover.h"
#include "knead/flow/set_cells.h"
#include "knead/flow/short_ways.h"

namespace knead::detail {

extern template SegmentMover path_lines_in<float>(const Segment&, const AdvectOptions&);
extern template SegmentMover path_lines_in<double>(const Segment&, const AdvectOptions&);

// A group's points side by side, and back.
struct GatheredPoints {
  std::vector<Vec3d> points;
  std::vector<std::size_t> lane;  // of the group
  std::vector<std::uint32_t> steps;

  explicit GatheredPoints(const LiveGroup& group) {
    for (int k = 0; k < group.block_count; ++k) {
      const std::size_t block = group.blocks[k];
      for (std::size_t i = 0; i < kBlock; ++i) {
        if ((group.members[block] >> i & 1) == 0) continue;
        const std::size_t at = block * kBlock + i;
        lane.push_back(at);
        points.push_back({group.points.x[at], group.points.y[at], group.points.z[at]});
      }
    }
    steps.resize(points.size());
  }

  void put_back(const LiveGroup& group) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
      double* const to[3] = {group.points.x + lane[i], group.points.y + lane[i], group.points.z + lane[i]};
      double& moved = group.moved[lane[i] / kBlock];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        moved = std::max(moved, std::abs(points[i][axis] - *to[axis]));
        *to[axis] = points[i][axis];
      }
      group.steps[lane[i]] += steps[i];
    }
  }
};

// The path lines of one segment.
template <class S, class Kernel>
class PathLines {
 public:
  template <class... Arguments>
  PathLines(const Segment& segment, const AdvectOptions& options, Arguments&&... arguments)
      : segment_(segment),
        method_(tableau(options.integrator)),
        coefficients_(method_),
        tolerance_(options.tolerance),
        kernel_{std::forward<Arguments>(arguments)...} {}

  GroupCounts operator()(const LiveGroup& group) const {
    PathLine<S, Kernel> line(segment_, kernel_, method_, coefficients_, tolerance_);
    GatheredPoints gathered(group);
    PathLineStats sum;
    const auto move = [&](std::size_t i) {
      PathLineStats stats;
      Vec3d& x = gathered.points[i];
      const Vec3d displacement = line.displacement(x, stats);
      if (displacement != Vec3d{}) x += displacement;
      gathered.steps[i] += stats.accepted;
      sum += stats;
    };
    const std::size_t count = gathered.points.size();
    bool grouped = false;
    if constexpr (std::is_same_v<Kernel, SetCells<S>>) {
      grouped = line.may_go_a_short_way();
      if (grouped) {
        const ShortWayTask<S> task{kernel_, segment_, line, gathered.points, gathered.steps};
        const std::vector<std::size_t> rest = go_short_ways(task, 0, count, sum);
        for (std::size_t k = 0; k < rest.size() && sum.complete; ++k) move(rest[k]);
      }
    }
    for (std::size_t i = 0; !grouped && i < count && sum.complete; ++i) move(i);
    gathered.put_back(group);
    return {sum.accepted, sum.rejected, sum.evaluations, sum.complete};
  }

 private:
  const Segment& segment_;
  const Tableau& method_;
  Coefficients<S> coefficients_;
  double tolerance_;
  Kernel kernel_;
};

template <class S, class Kernel, class... Arguments>
SegmentMover mover_with(const Segment& segment, const AdvectOptions& options, Arguments&&... arguments) {
  const auto lines =
      std::make_shared<const PathLines<S, Kernel>>(segment, options, std::forward<Arguments>(arguments)...);
  return [lines](const LiveGroup& group) { return (*lines)(group); };
}

// A motion or region with its numbers in the scalar S; the caller's own stay as they are.
template <class S, template <class> class Part>
Part<S> in_scalar(const Part<double>& part) {
  return static_cast<Part<S>>(part);
}
template <class S>
PackedSet<S> in_scalar(const PointSet<double>& set) {
  return packed<S>(set);
}
template <class S>
Handles<S, PackedSet<S>> in_scalar(const Handles<double>& region) {
  return {packed<S>(region.full), packed<S>(region.zero), Vec3<S>(region.sweep), Vec3<S>(region.turn_axis),
          static_cast<S>(region.turn_angle)};
}
template <class S>
CustomMotion in_scalar(const CustomMotion& motion) {
  return motion;
}
template <class S>
CustomRegion in_scalar(const CustomRegion& region) {
  return region;
}

// Calls body with the field as a SingleField of the right types: the dispatch on the variants, once per segment.
template <class S, class Body>
auto with_field(const Segment& segment, const Field& field, const Body& body) {
  return std::visit(
      [&](const auto& m, const auto& r) {
        auto motion = in_scalar<S>(m);
        auto region = in_scalar<S>(r);
        return body(SingleField<S, decltype(motion), decltype(region)>{
            std::move(motion), std::move(region), static_cast<Thresholds<S>>(field.thresholds), field.center,
            Vec3<S>(segment.displacement), segment.time_law == TimeLaw::blended});
      },
      field.motion, field.region);
}

template <class S>
SegmentMover path_lines_in(const Segment& segment, const AdvectOptions& options) {
  if (is_of_sets(segment)) return mover_with<S, SetCells<S>>(segment, options, segment, options.tolerance);
  if (segment.fields.size() == 1) {
    return with_field<S>(segment, segment.fields.front(), [&](const auto& field) {
      return mover_with<S, WholeField<S, std::decay_t<decltype(field)>>>(segment, options, field);
    });
  }
  FieldSum<S> sum;
  for (const Field& field : segment.fields) {
    sum.parts.push_back(with_field<S>(segment, field, [](const auto& field_in_s) {
      using Part = typename FieldSum<S>::Part;
      return Part{
          [field_in_s](const Vec3d& x0, const Vec3<S>& moved, double t) { return field_in_s.velocity(x0, moved, t); },
          [field_in_s](const Vec3d& x0, const Vec3<S>& moved, double t) {
            return field_in_s.hidden_speed(x0, moved, t);
          },
          [field_in_s](const Vec3d& x0, const Vec3<S>& moved, double t) { return field_in_s.width(x0, moved, t); }};
    }));
  }
  return mover_with<S, WholeField<S, FieldSum<S>>>(segment, options, sum);
}

}  // namespace knead::detail
