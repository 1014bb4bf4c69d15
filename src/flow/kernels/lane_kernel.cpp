// Kernels of the fields that no pack kernel evaluates: large point sets, curves, handles, several fields, blended
// fields and custom ones. They evaluate path lines one by one, or several in one cell of point sets.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "flow/closed_form.h"
#include "flow/segment_mover.h"
#include "flow/sets.h"
#include "flow/step_rule.h"

namespace knead::detail {

namespace {

// The displacement of a path line since its origin, and its time, in a stage of a step.
template <class S>
struct LanePlace {
  Vec3<S> moved;
  S t{0};
};

template <class S>
Vec3<S> lane_of(const Lanes3<S>& numbers, std::size_t lane) {
  return {numbers[0][lane], numbers[1][lane], numbers[2][lane]};
}

// The places of all lanes of a bundle in a stage.
template <class S>
class LanePlaces {
 public:
  LanePlaces(const Bundle<S>& bundle, const Stage<S>& stage) {
    const auto count = static_cast<std::size_t>(bundle.count);
    for (std::size_t lane = 0; lane < count; ++lane) t_[lane] = bundle.t[lane] + bundle.h[lane] * stage.c;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      S* const moved = moved_[axis];
      for (std::size_t lane = 0; lane < count; ++lane) moved[lane] = S(0);
      for (int j = 0; j < stage.count; ++j) {
        const S* const k = bundle.k[stage.slopes[j]][axis];
        const S weight = stage.weights[j];
        for (std::size_t lane = 0; lane < count; ++lane) moved[lane] += k[lane] * weight;
      }
      for (std::size_t lane = 0; lane < count; ++lane) moved[lane] *= bundle.h[lane];
      if (stage.from_start) continue;
      for (std::size_t lane = 0; lane < count; ++lane) moved[lane] += bundle.moved[axis][lane];
    }
  }

  LanePlace<S> operator[](std::size_t lane) const { return {lane_of(moved_, lane), t_[lane]}; }

 private:
  Lanes3<S> moved_;
  S t_[kBundle];
};

template <class S>
void set_slope(Bundle<S>& bundle, int k, std::size_t lane, const Vec3<S>& v) {
  for (std::size_t axis = 0; axis < 3; ++axis) bundle.k[k][axis][lane] = v[axis];
}

// The sum of several fields. Rare (sums of point sets are in sets.h), so that the indirect calls do not matter.
template <class S>
struct FieldSum {
  struct Part {
    std::function<Vec3<S>(const Vec3d&, const Vec3<S>&, double)> velocity;
    std::function<S(const Vec3d&, const Vec3<S>&, double)> hidden_speed;
    std::function<S(const Vec3d&, const Vec3<S>&, double)> width;
  };
  std::vector<Part> parts;

  Vec3<S> velocity(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    Vec3<S> sum{};
    for (const Part& part : parts) sum += part.velocity(x0, moved, t);
    return sum;
  }
  S hidden_speed(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    S greatest{0};
    for (const Part& part : parts) greatest = std::max(greatest, part.hidden_speed(x0, moved, t));
    return greatest;
  }
  S width(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    S least = std::numeric_limits<S>::infinity();
    for (const Part& part : parts) least = std::min(least, part.width(x0, moved, t));
    return least;
  }
};

// A segment whose field is the same function everywhere. F: a SingleField or FieldSum.
template <class S, class F>
struct WholeField {
  const Segment& segment;
  double reach = 0;     // reach_of_step
  bool masked = false;  // a mask acts
  F field;
  HandlePoints handles{segment};

  std::optional<double> next_contact(const void*& /*cell*/, const Vec3d& x, double t) const {
    return knead::next_contact(segment, x, t);
  }
  std::optional<Vec3d> closed_form(const Vec3d& x) const {
    if (masked) return std::nullopt;
    return handles.are_all() ? handles.closed_form(segment, x) : knead::closed_form(segment, x);
  }

  Vec3<S> velocity(const Origin& origin, const LanePlace<S>& at) const {
    return field.velocity(origin.x0, at.moved, static_cast<double>(at.t));
  }
};

// A segment of point sets, whose field is one function in each cell.
template <class S>
struct CellField {
  const Segment& segment;
  SetCells<S> cells;
  bool is_short;  // the tool's motion permits one step for the whole segment

  CellField(const Segment& of, double tolerance, const SegmentMask& mask)
      : segment(of),
        cells(of, tolerance, mask),
        is_short(norm(of.displacement) * std::abs(of.end - of.begin) <= kThirdOrderReach * reach_of_step(of)) {}

  using Cell = const SetCell<S>*;

  std::optional<double> next_contact(const void*& cell, const Vec3d& x, double t) const {
    auto place = static_cast<Cell>(cell);
    const std::optional<double> contact = cells.next_contact(place, segment, x, t);
    cell = place;
    return contact;
  }
  static std::optional<Vec3d> closed_form(const Vec3d& /*x*/) { return std::nullopt; }

  Vec3<S> velocity(const Origin& origin, const LanePlace<S>& at) const {
    return cells.velocity(static_cast<Cell>(origin.cell), origin.x0, at.moved, static_cast<double>(at.t));
  }
};

// The places of several path lines in one cell, and their velocities; unused places repeat the first.
template <class S>
struct SetPlaces {
  std::array<Vec3d, kPlaces> x0{};
  std::array<LanePlace<S>, kPlaces> at{};
  std::array<Vec3<S>, kPlaces> velocity{};
};

// Returns whether find_velocities can evaluate the cell's fields.
template <class S>
bool takes_several(const SetCell<S>& cell) {
  return std::all_of(cell.fields.begin(), cell.fields.end(),
                     [](const SetField<S>& field) { return field.region.curves->empty() && field.mask.is_empty(); });
}

// For the few places whose sums overflow; not inlined into the loop.
template <class S>
[[gnu::noinline]] RegionValue<S> evaluate_alone(const PackedSet<S>& set, const Vec3<S>& d) {
  return evaluate(set, d, S(0));
}

// Finds the velocity at every place. The bits of a place do not depend on the others.
template <class S>
[[gnu::flatten]] void find_velocities(const SetCell<S>& cell, SetPlaces<S>& paths) {
  paths.velocity = {};
  for (const SetField<S>& field : cell.fields) {
    const PackedSet<S>& set = field.region;
    const Translation<S> motion = field.motion;  // copies, which the stores below cannot change
    const Thresholds<S> thresholds = field.thresholds;
    const S scale = set.scale;
    const int exponent = set.exponent;
    std::array<Vec3<S>, kPlaces> d;
    Places<S> places;
    for (std::size_t i = 0; i < kPlaces; ++i) {
      d[i] = Vec3<S>(paths.x0[i] - field.center) + paths.at[i].moved - field.displacement * paths.at[i].t;
      places.x[i] = d[i].x;
      places.y[i] = d[i].y;
      places.z[i] = d[i].z;
      places.scale2[i] = scale * scale;
    }
    PlacesSums<S> sums;
    power_sums(*set.points, places, set.exponent / 2, sums);
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const PowerSums<S> sum{sums.value[i], {sums.gradient_x[i], sums.gradient_y[i], sums.gradient_z[i]}};
      RegionValue<S> r = region_of(sum, exponent, scale);
      if (!is_sound(r)) r = evaluate_alone(set, d[i]);
      paths.velocity[i] += velocity_where(r, motion, thresholds, d[i]);
    }
  }
}

// The same for at most kPlaces lanes of a bundle in one cell.
template <class S>
void evaluate_together(const SetCell<S>& cell, std::span<const std::uint16_t> lanes, const LanePlaces<S>& places,
                       int out, Bundle<S>& bundle) {
  SetPlaces<S> paths;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const std::size_t lane = lanes[i < lanes.size() ? i : 0];
    paths.x0[i] = bundle.origins[lane].x0;
    paths.at[i] = places[lane];
  }
  find_velocities(cell, paths);
  for (std::size_t i = 0; i < lanes.size(); ++i) set_slope(bundle, out, lanes[i], paths.velocity[i]);
}

// A stage of a step over the whole segment; the first one finds the cells. In a short segment path lines that begin in
// the same cell are evaluated together, which is faster and gives other bits than one by one. So the choice depends on
// the segment and the stage alone.
template <class S>
void evaluate_from_start(const CellField<S>& field, Bundle<S>& bundle, const Stage<S>& stage) {
  using Cell = typename CellField<S>::Cell;
  const auto cell_of = [&](std::size_t lane) { return static_cast<Cell>(bundle.origins[lane].cell); };
  const LanePlaces<S> places(bundle, stage);
  std::array<std::uint16_t, kBundle> lanes{};
  std::size_t count = 0;
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    Origin& origin = bundle.origins[lane];
    if (stage.count == 0) origin.cell = field.cells.cell_at(origin.x0, static_cast<double>(bundle.t[lane]));
    const Cell cell = cell_of(lane);
    if (field.is_short && cell != nullptr && takes_several(*cell)) {
      lanes[count++] = static_cast<std::uint16_t>(lane);
    } else {
      set_slope(bundle, stage.out, lane, field.velocity(origin, places[lane]));
    }
  }
  std::sort(lanes.begin(), lanes.begin() + count,
            [&](std::uint16_t a, std::uint16_t b) { return cell_of(a)->index < cell_of(b)->index; });
  for (std::size_t first = 0, last = 0; first < count; first = last) {
    while (last < count && last < first + kPlaces && cell_of(lanes[last]) == cell_of(lanes[first])) ++last;
    evaluate_together(*cell_of(lanes[first]), std::span(lanes).subspan(first, last - first), places, stage.out, bundle);
  }
}

// Whether the stages of a field find the width at their places, for the limits of the next step.
template <class F>
constexpr bool kFindsWidth = false;
template <class S, class M, class R>
constexpr bool kFindsWidth<WholeField<S, SingleField<S, M, R>>> = kHasWidth<R>;

template <class S, class F>
void lane_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const F& field = *static_cast<const F*>(data);
  if constexpr (std::is_same_v<F, CellField<S>>) {
    if (stage.from_start) return evaluate_from_start(field, bundle, stage);
  }
  const LanePlaces<S> places(bundle, stage);
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    if constexpr (kFindsWidth<F>) {
      const Vec3d& x0 = bundle.origins[lane].x0;
      const LanePlace<S> at = places[lane];
      S& width = (stage.out == 0 ? bundle.width : bundle.last_width)[lane];
      const auto t = static_cast<double>(at.t);
      set_slope(bundle, stage.out, lane, field.field.velocity_and_width(x0, at.moved, t, width));
    } else {
      set_slope(bundle, stage.out, lane, field.velocity(bundle.origins[lane], places[lane]));
    }
  }
}

template <class S, class F>
void limit_lanes(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const F& field = *static_cast<const F*>(data);
  const bool blended = field.segment.time_law == TimeLaw::blended;
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    const Vec3d& x0 = bundle.origins[lane].x0;
    const Vec3<S> moved = from_start ? Vec3<S>{} : lane_of(bundle.moved, lane);
    const auto t = static_cast<double>(bundle.t[lane]);
    limits.speed[lane] = field.field.hidden_speed(x0, moved, t);
    const S width = kFindsWidth<F> ? bundle.width[lane] : field.field.width(x0, moved, t);
    limits.reach[lane] = std::min(static_cast<S>(field.reach), static_cast<S>(kHandlesReach) * width);
    if (blended) limits.time[lane] = step_rule::longest_blended_step(bundle.t[lane]);
  }
}

// Lowers the limits as limit_by_mask of pack kernels does.
template <class S>
void lower_by_mask(const MaskView<S>& mask, const Vec3d& center, const Bundle<S>& bundle, bool from_start,
                   StepLimits<S>& limits) {
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    const Vec3<S> moved = from_start ? Vec3<S>{} : lane_of(bundle.moved, lane);
    const S reach = std::max(clearance(mask, Vec3<S>(bundle.origins[lane].x0 - center) + moved),
                             static_cast<S>(kMaskReach) * mask.width);
    const S longest = step_rule::longest_step(norm(lane_of(bundle.k[0], lane)), reach);
    limits.time[lane] = std::min(limits.time[lane], longest);
  }
}

template <class S, class F>
void limit_masked_lanes(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const Segment& segment = static_cast<const F*>(data)->segment;
  for (std::size_t lane = 0; lane < kBundle; ++lane) limits.time[lane] = std::numeric_limits<S>::max();
  if constexpr (!std::is_same_v<F, CellField<S>>) limit_lanes<S, F>(data, bundle, from_start, limits);
  const Vec3d& center = segment.fields.front().center;
  lower_by_mask(view_of<S>(segment.mask, center), center, bundle, from_start, limits);
}

template <class F>
double contact_or_never(const void* data, const Vec3d& x, double t, const void*& cell) {
  return static_cast<const F*>(data)->next_contact(cell, x, t).value_or(2);
}

// Adds the displacement to a point of the block.
void move_point(const BlockTask& task, std::size_t i, const Vec3d& by, Classified& result) {
  double* const to[3] = {task.points.x + i, task.points.y + i, task.points.z + i};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (by[axis] != 0) *to[axis] += by[axis];  // -0 stays -0
    result.moved = std::max(result.moved, std::abs(by[axis]));
  }
}

template <class F>
Classified classify_lanes(const void* data, const BlockTask& task) {
  const F& field = *static_cast<const F*>(data);
  const double begin = field.segment.begin;
  Classified result;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const std::uint64_t bit = std::uint64_t{1} << i;
    if ((task.members & bit) == 0) continue;
    const Vec3d x{task.points.x[i], task.points.y[i], task.points.z[i]};
    const void* cell = nullptr;
    const std::optional<double> contact = field.next_contact(cell, x, begin);
    if (!contact) continue;
    if (const std::optional<Vec3d> known = task.moves ? field.closed_form(x) : std::nullopt) {
      move_point(task, i, *known, result);
    } else if (*contact == begin) {
      result.inside |= bit;
    } else {
      result.later |= bit;
      task.start[i] = *contact;
    }
  }
  return result;
}

template <class S>
int follow_cells(const void* data, Bundle<S>& bundle) {
  const auto& field = *static_cast<const CellField<S>*>(data);
  int changed = 0;
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    Origin& origin = bundle.origins[lane];
    auto cell = static_cast<typename CellField<S>::Cell>(origin.cell);
    const LanePlace<S> at{lane_of(bundle.moved, lane), bundle.t[lane]};
    if (field.cells.keeps(cell, origin.x0 + Vec3d(at.moved), static_cast<double>(at.t))) continue;
    origin.cell = cell;
    set_slope(bundle, 0, lane, field.velocity(origin, at));
    ++changed;
  }
  return changed;
}

template <class S, class F>
BoundKernel<S> bound(std::shared_ptr<const F> field, bool masked) {
  BoundKernel<S> result;
  result.kernel.by_lanes = true;
  result.kernel.limits_place = true;
  result.kernel.stage = &lane_stage<S, F>;
  result.kernel.classify = &classify_lanes<F>;
  if constexpr (std::is_same_v<F, CellField<S>>) {
    result.kernel.follow = &follow_cells<S>;
  } else {
    result.kernel.limit = &limit_lanes<S, F>;
  }
  if (masked) result.kernel.limit = &limit_masked_lanes<S, F>;
  result.next_contact = &contact_or_never<F>;
  result.contact_data = field.get();
  result.field = std::move(field);
  return result;
}

template <class S, class F>
BoundKernel<S> whole_field(const Segment& segment, bool masked, F field) {
  using Whole = WholeField<S, F>;
  return bound<S, Whole>(
      std::make_shared<const Whole>(Whole{segment, reach_of_step(segment), masked, std::move(field)}), masked);
}

// A motion or region with its numbers in the scalar S; custom ones are unchanged.
template <class S, template <class> class Part>
Part<S> in_scalar(const Part<double>& part) {
  return static_cast<Part<S>>(part);
}
template <class S>
PackedSet<S> in_scalar(const PointSet<double>& set) {
  return packed<S>(set);
}
template <class S>
Handles<S, GuidedSet<S>> in_scalar(const Handles<double>& region) {
  return {guided<S>(region.full), guided<S>(region.zero), Vec3<S>(region.sweep), Vec3<S>(region.turn_axis),
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

// Calls body with the field as a SingleField of its types: the dispatch on the variants, once per segment.
template <class S, class Body>
auto with_field(const Segment& segment, const SegmentMask& mask, std::size_t index, const Body& body) {
  const Field& field = segment.fields[index];
  return std::visit(
      [&](const auto& m, const auto& r) {
        auto motion = in_scalar<S>(m);
        auto region = in_scalar<S>(r);
        return body(SingleField<S, decltype(motion), decltype(region)>{
            std::move(motion), std::move(region), static_cast<Thresholds<S>>(field.thresholds), field.center,
            Vec3<S>(segment.displacement), segment.time_law == TimeLaw::blended,
            mask.acts ? view_of<S>(segment.mask, field.center) : MaskView<S>{},
            mask.acts ? Vec3<S>(mask.offsets[index]) : Vec3<S>{}});
      },
      field.motion, field.region);
}

}  // namespace

template <class S>
BoundKernel<S> lane_kernel(const Segment& segment, double tolerance, const SegmentMask& mask) {
  if (is_of_sets(segment)) {
    return bound<S, CellField<S>>(std::make_shared<const CellField<S>>(segment, tolerance, mask), mask.acts);
  }
  if (segment.fields.size() == 1) {
    return with_field<S>(segment, mask, 0,
                         [&](auto field) { return whole_field<S>(segment, mask.acts, std::move(field)); });
  }
  FieldSum<S> sum;
  for (std::size_t i = 0; i < segment.fields.size(); ++i) {
    sum.parts.push_back(with_field<S>(segment, mask, i, [](const auto& field_in_s) {
      using Part = typename FieldSum<S>::Part;
      return Part{
          [field_in_s](const Vec3d& x0, const Vec3<S>& moved, double t) { return field_in_s.velocity(x0, moved, t); },
          [field_in_s](const Vec3d& x0, const Vec3<S>& moved, double t) {
            return field_in_s.hidden_speed(x0, moved, t);
          },
          [field_in_s](const Vec3d& x0, const Vec3<S>& moved, double t) { return field_in_s.width(x0, moved, t); }};
    }));
  }
  return whole_field<S>(segment, mask.acts, std::move(sum));
}

template BoundKernel<float> lane_kernel<float>(const Segment&, double, const SegmentMask&);
template BoundKernel<double> lane_kernel<double>(const Segment&, double, const SegmentMask&);

}  // namespace knead::detail
