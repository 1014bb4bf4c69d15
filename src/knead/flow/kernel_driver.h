// Path lines of a group's points, a bundle at a time. Internal to the flow room: part of the one source of all kernels.
#pragma once

#include <algorithm>
#include <limits>

#include "knead/flow/kernel_points.h"

namespace knead::detail {

// The part of the longest step up to which a segment is tried with the methods that evaluate v two and three times.
template <class S>
inline constexpr S kShortWay = S(1.0 / 16);
template <class S>
inline constexpr S kMiddleWay = S(1);
// What is expected of its error before, by the speed and the third power of the way's part of the intermediate region's
// width: above the tolerance, neither is tried.
template <class S>
inline constexpr S kExpected = S(0.01);
// Where it is expected to be below this part of the tolerance, and the second order is not allowed, the third is
// evaluated without a look at Euler's error. That changes no result.
template <class S>
inline constexpr S kConfident = S(0.1);
// What of Euler's error is expected of it then, times the square of that part: above the tolerance, the third order is
// not tried.
template <class S>
inline constexpr S kHopeless = S(0.1);
// Steps are never shorter than this part of the longest, or of the segment: there the estimate is rounding, which no
// step size mends.
template <class S>
inline constexpr S kShortest = sizeof(S) == 4 ? S(1.0 / 16) : S(1e-7);
inline constexpr int kStepLimit = 1'000'000;

template <class P>
KNEAD_INLINE P norm_of(const Vec3<P>& a) {
  return sqrt(norm2(a));
}

template <class P>
KNEAD_INLINE auto equal(const Vec3<P>& a, const Vec3<P>& b) {
  return (a.x == b.x) & (a.y == b.y) & (a.z == b.z);
}

template <class P>
KNEAD_INLINE Vec3<P> select_each(const typename P::Mask& mask, const Vec3<P>& a, const Vec3<P>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

// The lanes of the pack that begins at lane i which are in use.
template <class P>
KNEAD_INLINE std::uint32_t lanes_in_use(std::size_t i, int count) {
  const std::size_t rest = static_cast<std::size_t>(count) - i;
  const std::uint32_t all = static_cast<std::uint32_t>((std::uint64_t{1} << P::kSize) - 1);
  return rest >= P::kSize ? all : (std::uint32_t{1} << rest) - 1;
}

template <class P>
class GroupMover {
  using S = typename P::Scalar;

 public:
  GroupMover(const SegmentTask<S>& segment, const GroupTask<S>& group)
      : segment_(segment), group_(group), bundle_(*group.bundle), points_(segment, group) {
    const S speed = segment.tool_speed / segment.reach;
    tool_speed2_ = speed * speed;
    const S part = segment.reach / segment.width;
    const S expected = kExpected<S> * part * part * part * segment.reach / segment.tolerance;
    expected_error2_ = expected * expected;
  }

  GroupCounts run() {
    points_.clear();
    alignas(64) double start[kBlock];
    for (int i = 0; i < group_.block_count; ++i) {
      const std::size_t first = group_.blocks[i] * kBlock;
      const Coordinates points{group_.points.x + first, group_.points.y + first, group_.points.z + first};
      const bool between = (group_.between >> group_.blocks[i] & 1) != 0;
      const BlockTask task{points, group_.members[group_.blocks[i]], start};
      Classified found;
      if (between) {
        found.inside = task.members;
      } else {
        found = segment_.kernel.classify(segment_.field, task);
      }
      if (found.undecided != 0) points_.decide(task, found);
      points_.note_moved(first, found.moved);
      if ((found.inside | found.later) == 0) continue;
      if (bundle_.count + kBlock > kBundle) flush();
      points_.append(first, start, found);
    }
    flush();
    return counts_;
  }

 private:
  void flush() {
    if (bundle_.count == 0) return;
    const bool all = go_short_ways();
    if (!all) integrate();
    points_.scatter(all);
    points_.clear();
  }

  std::size_t lanes() const { return static_cast<std::size_t>(bundle_.count); }

  // Counts only those that are asked for: how many a path line takes depends on it alone.
  void evaluate(const Stage<S>& stage, int asked_for) {
    segment_.kernel.stage(segment_.field, bundle_, stage);
    counts_.evaluations += static_cast<std::uint64_t>(asked_for);
  }

  void find_hidden_speeds(bool from_start) {
    if (segment_.kernel.hidden_speed == nullptr) return;
    segment_.kernel.hidden_speed(segment_.field, bundle_, from_start, hidden_);
  }

  // The longest step that jumps over nothing, from the slope k_0: neither the point nor the region passes the other by
  // more than the segment's reach.
  KNEAD_INLINE P longest_step(std::size_t i) const {
    const Vec3<P> relative = load<P>(bundle_.k[0], i) - Vec3<P>(segment_.tool_velocity);
    P speed = maximum(norm_of(relative), P(segment_.tool_speed));
    if (segment_.kernel.hidden_speed != nullptr) speed = speed + P::load(hidden_ + i);
    return P(segment_.reach) / maximum(speed, P(std::numeric_limits<S>::min()));
  }

  // The whole way in one step of Heun's method, or of the third order's that begins with the same two slopes (Shu and
  // Osher 1988), where that is accurate; the others stay in the bundle. Whether none does.
  bool go_short_ways() {
    Stage<S> stage;
    stage.from_start = true;
    evaluate(stage, bundle_.count);
    find_hidden_speeds(true);
    int candidates = 0;
    hopeful_ = 0;
    leads_to_third_ = true;
    for (std::size_t i = 0; i < lanes(); i += P::kSize) candidates += measure_way(i);
    int done = 0;
    fill(done_, std::uint32_t{0}, kBundle / P::kSize);
    if (candidates > 0) {
      stage.weights[0] = S(1);
      stage.count = 1;
      stage.c = S(1);
      stage.out = 1;
      evaluate(stage, candidates);
      if (leads_to_third_) {
        hopeful_ = candidates;
      } else {
        done = judge<false>();
      }
    }
    if (hopeful_ > 0) {
      stage.weights[0] = stage.weights[1] = S(0.25);
      stage.slopes[1] = 1;
      stage.count = 2;
      stage.c = S(0.5);
      stage.out = 2;
      evaluate(stage, 0);
      done = judge<true>();
      counts_.evaluations += static_cast<std::uint64_t>(hopeful_);
    }
    counts_.accepted += static_cast<std::uint64_t>(done);
    if (done == bundle_.count) return true;
    for (std::size_t i = 0; done > 0 && i < lanes(); ++i) bundle_.result_steps[i] = S(is_done(i) ? 1 : 0);
    slots_are_lanes_ = true;
    if (done > 0) drop_done();
    fill(bundle_.steps, S(0), lanes());
    return false;
  }

  bool is_done(std::size_t lane) const { return (done_[lane / P::kSize] >> lane % P::kSize & 1) != 0; }

  // Takes what is done out of the bundle.
  void drop_done() {
    if (slots_are_lanes_) {
      for (std::size_t i = 0; i < lanes(); ++i) bundle_.slot[i] = static_cast<std::uint16_t>(i);
      slots_are_lanes_ = false;
    }
    std::size_t to = 0;
    for (std::size_t from = 0; from < lanes(); ++from) {
      if (is_done(from)) continue;
      if (from != to) move_lane(from, to);
      ++to;
    }
    bundle_.count = static_cast<int>(to);
  }

  void move_lane(std::size_t from, std::size_t to) {
    for (int axis = 0; axis < 3; ++axis) {
      bundle_.base[axis][to] = bundle_.base[axis][from];
      bundle_.moved[axis][to] = bundle_.moved[axis][from];
      bundle_.k[0][axis][to] = bundle_.k[0][axis][from];
    }
    bundle_.t[to] = bundle_.t[from];
    bundle_.trial[to] = bundle_.trial[from];
    bundle_.steps[to] = bundle_.steps[from];
    bundle_.at_contact[to] = bundle_.at_contact[from];
    bundle_.slot[to] = bundle_.slot[from];
  }

  // Into h all of the way, and into `trial` the square of which part of the longest step that is: a great number where
  // it is not worth trying, or the slope does not tell: the point being at rest in space or in the tool's frame.
  // Returns how many lanes may go their way in one step.
  KNEAD_INLINE int measure_way(std::size_t i) {
    const P h = P(segment_.end) - P::load(bundle_.t + i);
    h.store(bundle_.h + i);
    const Vec3<P> k = load<P>(bundle_.k[0], i);
    const P by_reach(S(1) / segment_.reach);
    P speed2 = maximum(norm2((k - Vec3<P>(segment_.tool_velocity)) * by_reach), P(tool_speed2_));
    if (segment_.kernel.hidden_speed != nullptr) {
      const P speed = mul_add(P::load(hidden_ + i), by_reach, sqrt(speed2));
      speed2 = speed * speed;
    }
    P part2 = h * h * speed2;
    const P expected2 = part2 * part2 * part2 * speed2 * P(expected_error2_);
    part2 = select(expected2 <= P(1), part2, P(1e9));
    part2.store(bundle_.trial + i);
    leads_to_third_ = leads_to_third_ && bits(part2 <= P(kShortWay<S> * kShortWay<S>)) == 0 &&
                      bits(expected2 > P(kConfident<S> * kConfident<S>)) == 0;
    const std::uint32_t rests = resting(i) | carried(i);
    for (std::size_t lane = 0; rests != 0 && lane < P::kSize; ++lane) {
      if ((rests >> lane & 1) != 0) bundle_.trial[i + lane] = S(1e9);
    }
    const std::uint32_t may = bits(part2 <= P(kMiddleWay<S> * kMiddleWay<S>)) & ~rests;
    return __builtin_popcount(may & lanes_in_use<P>(i, bundle_.count));
  }

  // Lanes where v is 0 for another reason than that a tool is just arriving.
  KNEAD_INLINE std::uint32_t resting(std::size_t i) const {
    std::uint32_t rests = bits(equal(load<P>(bundle_.k[0], i), Vec3<P>{P(0), P(0), P(0)}));
    for (std::size_t k = 0; rests != 0 && k < P::kSize; ++k) {
      if (bundle_.at_contact[i + k] != 0) rests &= ~(std::uint32_t{1} << k);
    }
    return rests;
  }

  // Lanes that rest in the rigid core of the tool.
  KNEAD_INLINE std::uint32_t carried(std::size_t i) const {
    if (!segment_.carries) return 0;
    return bits(equal(load<P>(bundle_.k[0], i), Vec3<P>(segment_.tool_velocity)));
  }

  // Which lanes go their way accurately with k_0 and k_1, and with k_2 if that is known: the error of a method is about
  // that of the next lower order, times the part of the longest step. Returns how many do.
  template <bool with_third>
  int judge() {
    int count = 0;
    hopeful_ = 0;
    const P one(1);
    const P by_tolerance(S(1) / segment_.tolerance);
    for (std::size_t i = 0; i < lanes(); i += P::kSize) {
      const Vec3<P> k0 = load<P>(bundle_.k[0], i);
      const Vec3<P> k1 = load<P>(bundle_.k[1], i);
      // The part by the speed where the way leads, too: at its beginning a turning tool may be all but at rest.
      const P h = P::load(bundle_.h + i);
      const P speed2_there = norm2((k1 - Vec3<P>(segment_.tool_velocity)) * P(S(1) / segment_.reach));
      const P part2 = maximum(P::load(bundle_.trial + i), h * h * speed2_there);
      const P zero(0);
      Vec3<P> slope = (k0 + k1) * P(0.5);
      const P error2 = norm2((k1 - slope) * by_tolerance) * part2;
      auto good = (part2 <= P(kShortWay<S> * kShortWay<S>)) & (error2 <= one) & (norm2(slope) > zero);
      const auto hopeful =
          (part2 <= P(kMiddleWay<S> * kMiddleWay<S>)) & (error2 * part2 * P(kHopeless<S> * kHopeless<S>) <= one);
      hopeful_ += __builtin_popcount(bits(hopeful) & ~bits(good) & lanes_in_use<P>(i, bundle_.count));
      if constexpr (with_third) {
        const Vec3<P> change = (load<P>(bundle_.k[2], i) - slope) * P(2.0 / 3);
        const Vec3<P> third = slope + change;
        const P third_error2 = norm2(change * by_tolerance) * part2;
        slope = select_each(good, slope, third);
        good = good | (hopeful & (third_error2 <= one) & (norm2(third) > zero));
      }
      store(slope * P::load(bundle_.h + i), bundle_.result, i);
      done_[i / P::kSize] = bits(good) & lanes_in_use<P>(i, bundle_.count);
      count += __builtin_popcount(done_[i / P::kSize]);
    }
    return count;
  }

  // All that is left of the bundle, by steps whose error is estimated.
  void integrate() {
    for (int axis = 0; axis < 3; ++axis) fill(bundle_.moved[axis], S(-0.0), kBundle);
    for (std::size_t i = 0; i < lanes(); i += P::kSize) {
      const P way = P(segment_.end) - P::load(bundle_.t + i);
      maximum(way, -way).store(bundle_.trial + i);
    }
    const Method<S>& method = *segment_.method;
    for (int round = 0;; ++round) {
      const int active = settle();
      if (active == 0) return;
      if (round == kStepLimit || !counts_.complete) {
        counts_.complete = false;
        return;
      }
      find_hidden_speeds(false);
      for (std::size_t i = 0; i < lanes(); i += P::kSize) choose_step(i);
      for (int k = 1; k < method.stage_count; ++k) evaluate(method.stages[k], active);
      for (std::size_t i = 0; i < lanes(); i += P::kSize) finish_step(i);
      fill(bundle_.at_contact, std::uint8_t{0}, lanes());
      if (!method.first_same_as_last) evaluate(Stage<S>{}, active);
    }
  }

  // Deals with the lanes that no step is needed for, and takes finished ones out when they are many. Returns how many
  // are still on their way.
  int settle() {
    int active = 0;
    for (std::size_t i = 0; i < lanes(); i += P::kSize) {
      const std::uint32_t used = lanes_in_use<P>(i, bundle_.count);
      done_[i / P::kSize] = bits(P::load(bundle_.t + i) == P(segment_.end));
      const std::uint32_t candidates = (resting(i) | carried(i)) & used & ~done_[i / P::kSize];
      for (std::size_t k = 0; candidates != 0 && k < P::kSize; ++k) {
        if ((candidates >> k & 1) != 0 && !goes_on(i + k)) done_[i / P::kSize] |= std::uint32_t{1} << k;
      }
      active += __builtin_popcount(used & ~done_[i / P::kSize]);
    }
    if (active == 0) {
      keep_results();
    } else if (active <= bundle_.count - std::max(static_cast<int>(P::kSize), bundle_.count / 4)) {
      keep_results();
      drop_done();
    }
    return active;
  }

  // Of a lane that rests, in space or in the tool's frame: whether it will be moved by the tool again, and from when
  // on. What it is carried along with the tool is added exactly.
  bool goes_on(std::size_t lane) {
    const std::size_t point = points_.point_of(slots_are_lanes_ ? lane : bundle_.slot[lane]);
    double* const to[3] = {group_.points.x + point, group_.points.y + point, group_.points.z + point};
    const S t = bundle_.t[lane];
    bundle_.t[lane] = segment_.end;
    bool carried = segment_.carries;
    for (int axis = 0; axis < 3; ++axis) {
      carried = carried && bundle_.k[0][axis][lane] == segment_.tool_velocity[static_cast<std::size_t>(axis)];
    }
    if (carried) {
      const double rest = static_cast<double>(segment_.end) - static_cast<double>(t);
      for (int axis = 0; axis < 3; ++axis) {
        const double by = segment_.displacement[static_cast<std::size_t>(axis)] * rest;
        *to[axis] += by;
        const double before = bundle_.moved[axis][lane];
        points_.note_moved(point, (by < 0 ? -by : by) + (before < 0 ? -before : before));
      }
      return false;
    }
    const Vec3d x{*to[0] + bundle_.moved[0][lane], *to[1] + bundle_.moved[1][lane], *to[2] + bundle_.moved[2][lane]};
    const double contact = segment_.next_contact(segment_.segment, x, static_cast<double>(t));
    if (contact > 1) return false;
    bundle_.t[lane] = static_cast<S>(contact);
    bundle_.at_contact[lane] = 1;
    return bundle_.t[lane] != segment_.end;
  }

  // The length of the lanes' next step, 0 for finished ones.
  KNEAD_INLINE void choose_step(std::size_t i) {
    const P way = P(segment_.end) - P::load(bundle_.t + i);
    const P remaining = maximum(way, -way);
    const P longest = longest_step(i);
    const P shortest = minimum(longest, P(1)) * P(kShortest<S>);
    const P h = minimum(minimum(maximum(P::load(bundle_.trial + i), shortest), longest), remaining);
    shortest.store(bundle_.shortest + i);
    (segment_.end >= segment_.begin ? h : -h).store(bundle_.h + i);
  }

  // Accepts the step where its error is small enough.
  KNEAD_INLINE void finish_step(std::size_t i) {
    const Method<S>& method = *segment_.method;
    const P signed_h = P::load(bundle_.h + i);
    const P h = maximum(signed_h, -signed_h);
    const P t = P::load(bundle_.t + i);
    const P end(segment_.end);
    const P remaining = maximum(end - t, t - end);
    const P by_tolerance(S(1) / segment_.tolerance);
    const Vec3<P> slope = combine<P>(bundle_, method.slope, i);
    const P error2 = norm2(combine<P>(bundle_, method.error, i) * by_tolerance);
    const P noise2 = norm2(slope * (by_tolerance * P(S(8) * std::numeric_limits<S>::epsilon())));
    const auto active = remaining > P(0);
    const auto accept = ((error2 <= P(1) + noise2) | (h <= P::load(bundle_.shortest + i))) & active;
    const auto arrived = accept & (h >= remaining);
    const Vec3<P> moved = load<P>(bundle_.moved, i);
    store(select_each(accept, mul_add(slope, signed_h, moved), moved), bundle_.moved, i);
    select(arrived, end, select(accept, t + signed_h, t)).store(bundle_.t + i);
    (P::load(bundle_.steps + i) + select(accept, P(1), P(0))).store(bundle_.steps + i);
    const std::uint32_t used = lanes_in_use<P>(i, bundle_.count) & bits(active);
    count_steps(used, bits(accept));
    if ((bits(error2 < P(std::numeric_limits<S>::max())) & used) != used) counts_.complete = false;
    if ((bits(arrived) & used) == used) return;  // nothing goes on from here
    (h * step_factor(error2)).store(bundle_.trial + i);
    if (method.first_same_as_last) {
      const Vec3<P> last = load<P>(bundle_.k[method.stage_count - 1], i);
      store(select_each(accept, last, load<P>(bundle_.k[0], i)), bundle_.k[0], i);
    }
  }

  void count_steps(std::uint32_t active, std::uint32_t accepted) {
    const int taken = __builtin_popcount(active & accepted);
    counts_.accepted += static_cast<std::uint64_t>(taken);
    counts_.rejected += static_cast<std::uint64_t>(__builtin_popcount(active) - taken);
  }

  // The error per unit of time falls with the step's error_order-th power, whose root is taken by square roots only.
  // Given is the square of the error in tolerances.
  KNEAD_INLINE P step_factor(const P& error2) const {
    P root = sqrt(sqrt(P(1) / maximum(error2, P(1e-8))));
    if (segment_.method->error_order != 2) root = sqrt(root);
    return minimum(maximum(root * P(0.9), P(0.2)), P(5));
  }

  // Of the lanes that are done.
  void keep_results() {
    if (slots_are_lanes_) {  // what is not done will be overwritten
      for (int axis = 0; axis < 3; ++axis) copy_numbers(bundle_.moved[axis], bundle_.result[axis]);
      copy_numbers(bundle_.steps, bundle_.result_steps);
      return;
    }
    for (std::size_t lane = 0; lane < lanes(); ++lane) {
      if (!is_done(lane)) continue;
      for (int axis = 0; axis < 3; ++axis) bundle_.result[axis][bundle_.slot[lane]] = bundle_.moved[axis][lane];
      bundle_.result_steps[bundle_.slot[lane]] = bundle_.steps[lane];
    }
  }

  void copy_numbers(const S* from, S* to) const {
    for (std::size_t i = 0; i < lanes(); i += P::kSize) P::load(from + i).store(to + i);
  }

  alignas(64) S hidden_[kBundle] = {};
  const SegmentTask<S>& segment_;
  const GroupTask<S>& group_;
  Bundle<S>& bundle_;
  BundlePoints<P> points_;
  GroupCounts counts_;
  S tool_speed2_ = 0;  // relative to the reach of a step
  S expected_error2_ = 0;
  int hopeful_ = 0;  // path lines for which the third order is worth trying
  std::uint32_t done_[kBundle / P::kSize] = {};
  bool slots_are_lanes_ = true;
  bool leads_to_third_ = true;  // whether the second order need not be judged before
};

}  // namespace knead::detail
