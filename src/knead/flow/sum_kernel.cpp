// The kernel of sums. Internal to the flow room.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "knead/flow/contact.h"
#include "knead/flow/culling.h"
#include "knead/flow/lane_fields.h"
#include "knead/flow/step_rule.h"
#include "knead/flow/summed.h"

namespace knead::detail {

namespace {

// A ball that moves along with a part, and holds its support.
struct MovingBall {
  Vec3d center;  // at t = 0
  Vec3d by;      // over the unit of time
  double radius = 0;

  double gap(const Vec3d& x, double t) const { return norm(x - center - by * t) - radius; }
};

constexpr double kBallMargin = 1e-6;

MovingBall ball_around(const Segment& part) {
  const Vec3d by = part.time_law == TimeLaw::swept ? part.displacement : Vec3d{};
  const bool is_ball = part.fields.size() == 1 && std::holds_alternative<Ball<double>>(part.fields.front().region);
  if (is_ball && part.time_law == TimeLaw::swept) {
    return {part.fields.front().center, by, part.fields.front().thresholds.outer * (1 + kBallMargin)};
  }
  Segment resting = part;  // its box moves along
  if (part.time_law == TimeLaw::swept) resting.displacement = {};
  const Box box = support_of(resting);
  if (box.empty()) return {{}, {}, 0};
  if (!(box.max.x < kFar)) return {{}, {}, std::numeric_limits<double>::infinity()};
  return {box.center(), by, 0.5 * box.diagonal() * (1 + kBallMargin)};
}

template <class S>
struct SumPart {
  std::unique_ptr<const Segment> segment;
  BoundKernel<S> bound;
  MovingBall ball;
  Vec3d center;  // what the kernel's positions are relative to
  Vec3<S> tool_velocity;
  S tool_speed{0};
  S reach{0};
  bool finds_cells = false;   // each place's cell is to be found
  bool leaves_width = false;  // the stage leaves the width to the limits
};

// The lanes that a part may move, and a bundle with their places.
template <class S>
struct NearLanes {
  Bundle<S> bundle;
  std::array<std::uint16_t, kBundle> lanes{};
};

template <class S>
NearLanes<S>& scratch() {
  static thread_local const std::unique_ptr<NearLanes<S>> scratch = std::make_unique<NearLanes<S>>();
  return *scratch;
}

// v of a part where the near lanes are.
template <class S>
void evaluate_part(const SumPart<S>& part, NearLanes<S>& near) {
  if (part.finds_cells) {
    part.bound.kernel.follow(part.bound.field.get(), near.bundle);  // outside all cells k_0 stays 0
  } else {
    part.bound.kernel.stage(part.bound.field.get(), near.bundle, Stage<S>{});
  }
}

template <class S>
struct SumField {
  const Segment& sum;
  std::vector<SumPart<S>> parts{};
  std::array<double, 3> planes{};  // NaN: none

  // Gathers the lanes that are asked for and that the part may move. Returns how many.
  int gather(const SumPart<S>& part, const Bundle<S>& from, const LanePlaces<S>& places, NearLanes<S>& to) const {
    int count = 0;
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(from.count); ++lane) {
      if (!from.asked.has(lane)) continue;
      const LanePlace<S> at = places[lane];
      const Vec3d& x0 = from.origins[lane].x0;
      const Vec3d x = x0 + Vec3d(at.moved);
      const auto t = static_cast<double>(at.t);
      if (!(part.ball.gap(x, t) < 0)) continue;
      const auto i = static_cast<std::size_t>(count);
      to.bundle.origins[i] = {x0, nullptr};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        to.bundle.base[axis][i] = static_cast<S>(x0[axis] - part.center[axis]);
        to.bundle.moved[axis][i] = at.moved[axis];
        to.bundle.k[0][axis][i] = S(0);
      }
      to.bundle.t[i] = at.t;
      to.lanes[i] = static_cast<std::uint16_t>(lane);
      ++count;
    }
    to.bundle.count = count;
    to.bundle.asked.fill(static_cast<std::size_t>(count));
    return count;
  }

  // Whether a lane is exactly in one of the planes, and has been all the time.
  bool is_in_plane(const Bundle<S>& bundle, std::size_t lane, std::size_t axis, const LanePlaces<S>& places) const {
    return bundle.origins[lane].x0[axis] == planes[axis] && places[lane].moved[axis] == S(0);
  }

  void evaluate(Bundle<S>& bundle, const Stage<S>& stage) const {
    const LanePlaces<S> places(bundle, stage);
    NearLanes<S>& near = scratch<S>();
    std::array<Lanes3<S>, kMostParts> slopes;
    const auto lanes = static_cast<std::size_t>(bundle.count);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) std::fill_n(slopes[k][axis], lanes, S(0));
      const int count = gather(parts[k], bundle, places, near);
      if (count == 0) continue;
      evaluate_part(parts[k], near);
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) slopes[k][axis][near.lanes[i]] = near.bundle.k[0][axis][i];
      }
    }
    add_up(slopes, lanes);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::copy_n(slopes[0][axis], lanes, bundle.k[stage.out][axis]);
      if (std::isnan(planes[axis])) continue;
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        if (is_in_plane(bundle, lane, axis, places)) bundle.k[stage.out][axis][lane] = S(0);
      }
    }
  }

  // Neighbours first, then pairs of them, and so on, as mirror images in one plane, two and three follow each other.
  void add_up(std::array<Lanes3<S>, kMostParts>& slopes, std::size_t lanes) const {
    for (std::size_t stride = 1; stride < parts.size(); stride *= 2) {
      for (std::size_t k = 0; k + stride < parts.size(); k += 2 * stride) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (std::size_t lane = 0; lane < lanes; ++lane) slopes[k][axis][lane] += slopes[k + stride][axis][lane];
        }
      }
    }
  }

  std::optional<double> next_contact(const Vec3d& x, double t) const {
    std::optional<double> first;
    for (const SumPart<S>& part : parts) {
      const void* cell = nullptr;
      const double contact = part.finds_cells ? part.bound.next_contact(part.bound.contact_data, x, t, cell)
                                              : knead::next_contact(*part.segment, x, t).value_or(2);
      if (contact > 1) continue;
      const bool earlier = !first || (sum.end >= sum.begin ? contact < *first : contact > *first);
      if (earlier) first = contact;
    }
    return first;
  }
};

// For each lane: how fast it passes a part, in units of what it may pass, at most; what limits its steps else.
template <class S>
struct LaneLimits {
  S rate[kBundle];
  S reach[kBundle];
  S time[kBundle];
};

// The limits of one part's own field, for the lanes near it.
template <class S>
void find_own_limits(const SumPart<S>& part, const Bundle<S>& bundle, NearLanes<S>& near, StepLimits<S>& own) {
  std::fill_n(own.speed, kBundle, S(0));
  std::fill_n(own.reach, kBundle, part.reach);
  std::fill_n(own.time, kBundle, std::numeric_limits<S>::max());
  if (part.bound.kernel.limit == nullptr || near.bundle.count == 0) return;
  if (part.leaves_width) evaluate_part(part, near);
  for (std::size_t i = 0; i < static_cast<std::size_t>(near.bundle.count); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) near.bundle.k[0][axis][i] = bundle.k[0][axis][near.lanes[i]];
  }
  part.bound.kernel.limit(part.bound.field.get(), near.bundle, false, own);
}

template <class S>
void limit_by_part(const SumField<S>& field, const SumPart<S>& part, const Bundle<S>& bundle,
                   const LanePlaces<S>& places, LaneLimits<S>& limits) {
  NearLanes<S>& near = scratch<S>();
  field.gather(part, bundle, places, near);
  StepLimits<S> own;
  find_own_limits(part, bundle, near, own);
  std::size_t next = 0;
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    const bool is_near = next < static_cast<std::size_t>(near.bundle.count) && near.lanes[next] == lane;
    const LanePlace<S> at = places[lane];
    const Vec3d x = bundle.origins[lane].x0 + Vec3d(at.moved);
    const double gap = is_near ? 0 : std::max(0.0, part.ball.gap(x, static_cast<double>(at.t)));
    const S reach = (is_near ? own.reach[next] : part.reach) + static_cast<S>(gap);
    const S relative = norm(lane_of(bundle.k[0], lane) - part.tool_velocity);
    const S speed = std::max(relative, part.tool_speed) + (is_near ? own.speed[next] : S(0));
    limits.rate[lane] = std::max(limits.rate[lane], speed / reach);
    limits.reach[lane] = std::min(limits.reach[lane], reach);
    if (is_near) limits.time[lane] = std::min(limits.time[lane], own.time[next]);
    if (is_near) ++next;
  }
}

template <class S>
void sum_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  static_cast<const SumField<S>*>(data)->evaluate(bundle, stage);
}

// The mover divides the speed by the reach: it gets a speed with which that is the greatest rate of a part.
template <class S>
void limit_sum(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const auto& field = *static_cast<const SumField<S>*>(data);
  Stage<S> here;
  here.from_start = from_start;
  const LanePlaces<S> places(bundle, here);
  LaneLimits<S> all;
  std::fill_n(all.rate, kBundle, S(0));
  std::fill_n(all.reach, kBundle, std::numeric_limits<S>::max());
  std::fill_n(all.time, kBundle, std::numeric_limits<S>::max());
  for (const SumPart<S>& part : field.parts) limit_by_part(field, part, bundle, places, all);
  for (std::size_t lane = 0; lane < static_cast<std::size_t>(bundle.count); ++lane) {
    if (!bundle.asked.has(lane)) continue;
    limits.reach[lane] = all.reach[lane];
    limits.time[lane] = all.time[lane];
    limits.speed[lane] = all.rate[lane] * all.reach[lane] - norm(lane_of(bundle.k[0], lane));
  }
}

template <class S>
double contact_or_never(const void* data, const Vec3d& x, double t, const void*& /*cell*/) {
  return static_cast<const SumField<S>*>(data)->next_contact(x, t).value_or(2);
}

template <class S>
Classified classify_sum(const void* data, const BlockTask& task) {
  const auto& field = *static_cast<const SumField<S>*>(data);
  Classified result;
  for (std::uint64_t rest = task.members; rest != 0; rest &= rest - 1) {
    const auto i = static_cast<std::size_t>(__builtin_ctzll(rest));
    const std::optional<double> contact =
        field.next_contact({task.points.x[i], task.points.y[i], task.points.z[i]}, field.sum.begin);
    if (!contact) continue;
    const std::uint64_t bit = std::uint64_t{1} << i;
    if (*contact == field.sum.begin) {
      result.inside |= bit;
    } else {
      result.later |= bit;
      task.start[i] = *contact;
    }
  }
  return result;
}

template <class S>
SumPart<S> make_part(const Segment& segment, const SegmentMask& mask, const AdvectOptions& options,
                     const Kernels<S>& kernels) {
  SumPart<S> part;
  part.segment = std::make_unique<const Segment>(segment);
  part.bound = kernel_of<S>(*part.segment, options.tolerance, mask, kernels);
  part.ball = ball_around(segment);
  const SegmentTask<double> task = task_in_double(segment, options.tolerance);
  part.center = task.center;
  part.tool_velocity = Vec3<S>(task.tool_velocity);
  part.tool_speed = static_cast<S>(task.tool_speed);
  part.reach = static_cast<S>(std::min(task.reach, static_cast<double>(std::numeric_limits<S>::max())));
  part.finds_cells = part.bound.kernel.follow != nullptr;
  part.leaves_width = !segment.fields.empty() && std::holds_alternative<Handles<double>>(segment.fields.front().region);
  return part;
}

}  // namespace

template <class S>
BoundKernel<S> sum_kernel(const Segment& sum, const AdvectOptions& options, const Kernels<S>& kernels) {
  auto field = std::make_shared<SumField<S>>(SumField<S>{sum});
  const std::vector<Segment> parts = parts_of(sum);
  const std::vector<SegmentMask> masks = masks_on(sum, parts);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    field->parts.push_back(make_part<S>(parts[i], masks[i], options, kernels));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    field->planes[axis] = sum.mirrored_at[axis].value_or(std::numeric_limits<double>::quiet_NaN());
  }
  BoundKernel<S> result;
  result.kernel.by_lanes = true;
  result.kernel.limits_place = true;
  result.kernel.stage = &sum_stage<S>;
  result.kernel.limit = &limit_sum<S>;
  result.kernel.classify = &classify_sum<S>;
  result.next_contact = &contact_or_never<S>;
  result.contact_data = field.get();
  result.field = std::move(field);
  return result;
}

template BoundKernel<float> sum_kernel<float>(const Segment&, const AdvectOptions&, const Kernels<float>&);
template BoundKernel<double> sum_kernel<double>(const Segment&, const AdvectOptions&, const Kernels<double>&);

}  // namespace knead::detail
