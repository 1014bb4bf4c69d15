// advect for one segment in one scalar. Internal to the flow room: instantiated in advect_float.cpp and
// advect_double.cpp.
#pragma once

#include "knead/field/packed_set.h"
#include "knead/flow/advect.h"
#include "knead/flow/path_line.h"
#include "knead/flow/set_cells.h"
#include "knead/flow/short_ways.h"
#include "knead/math/parallel.h"

namespace knead::detail {

template <class S>
AdvectResult advect_segment(const Segment& segment, std::span<Vec3d> points, const AdvectOptions& options);

extern template AdvectResult advect_segment<float>(const Segment&, std::span<Vec3d>, const AdvectOptions&);
extern template AdvectResult advect_segment<double>(const Segment&, std::span<Vec3d>, const AdvectOptions&);

inline bool within(const Cylinder& cylinder, const Vec3d& x) {
  const Vec3d d = x - cylinder.point;
  const Vec3d across = d - cylinder.direction * dot(cylinder.direction, d);
  return norm2(across) <= cylinder.radius * cylinder.radius;
}

template <class S, class Kernel>
AdvectResult advect_with(const Kernel& kernel, const Segment& segment, std::span<Vec3d> points,
                         const AdvectOptions& options) {
  constexpr bool kOfSets = std::is_same_v<Kernel, SetCells<S>>;
  constexpr std::size_t kGrain = kOfSets ? 4096 : 1024;  // enough for several to begin in a cell
  const Tableau& method = tableau(options.integrator);
  const Coefficients<S> coefficients(method);
  Segment to_start = segment;  // whether a point belongs to the cylinder is known at t = 0
  to_start.end = 0;
  std::atomic<std::uint64_t> accepted{0};
  std::atomic<std::uint64_t> rejected{0};
  std::atomic<std::uint64_t> evaluations{0};
  std::atomic<bool> complete{true};
  const auto chunk = [&](std::size_t begin, std::size_t end) {
    if (!complete || (options.progress != nullptr && options.progress->cancel)) return;
    PathLine<S, Kernel> line(segment, kernel, method, coefficients, options.tolerance);
    PathLine<S, Kernel> line_to_start(to_start, kernel, method, coefficients, options.tolerance);
    PathLineStats sum;
    const auto move = [&](std::size_t i) {
      PathLineStats stats;
      Vec3d& x = points[i];
      if (segment.cylinder) {
        const Vec3d start = x + line_to_start.displacement(x, stats);
        if (!within(*segment.cylinder, start)) return;
      }
      const Vec3d displacement = line.displacement(x, stats);
      if (displacement != Vec3d{}) x += displacement;
      if (!options.steps.empty()) options.steps[i] += static_cast<std::uint32_t>(stats.accepted);
      sum += stats;
    };
    bool grouped = false;
    if constexpr (kOfSets) {
      grouped = !segment.cylinder && line.may_go_a_short_way();
      if (grouped) {
        const ShortWayTask<S> task{kernel, segment, line, points, options.steps};
        const std::vector<std::size_t> rest = go_short_ways(task, begin, end, sum);
        for (std::size_t k = 0; k < rest.size() && sum.complete; ++k) move(rest[k]);
      }
    }
    for (std::size_t i = begin; !grouped && i < end && sum.complete; ++i) move(i);
    accepted += sum.accepted;
    rejected += sum.rejected;
    evaluations += sum.evaluations;
    if (!sum.complete) {
      complete = false;
      return;
    }
    if (options.progress != nullptr) options.progress->done += end - begin;
  };
  parallel_for(points.size(), kGrain, options.threads, chunk);
  AdvectStatus status = complete ? AdvectStatus::done : AdvectStatus::step_limit;
  if (options.progress != nullptr && options.progress->cancel) status = AdvectStatus::cancelled;
  return {status, accepted, rejected, evaluations};
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
AdvectResult advect_segment(const Segment& segment, std::span<Vec3d> points, const AdvectOptions& options) {
  if (is_of_sets(segment)) {
    return advect_with<S>(SetCells<S>(segment, options.tolerance), segment, points, options);
  }
  if (segment.fields.size() == 1) {
    return with_field<S>(segment, segment.fields.front(), [&](const auto& field) {
      return advect_with<S>(WholeField<S, std::decay_t<decltype(field)>>{field}, segment, points, options);
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
  return advect_with<S>(WholeField<S, FieldSum<S>>{sum}, segment, points, options);
}

}  // namespace knead::detail
