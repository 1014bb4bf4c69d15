// Bundles of path lines: filled with points and written back, evaluated, and moved through a whole segment in one step.
// Internal: part of the one source of all kernels.
#pragma once

#include <algorithm>

#include "flow/kernels/kernel_stage.h"
#include "flow/step_rule.h"

namespace knead::detail {

template <class T>
KNEAD_INLINE void fill(T* to, T value, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) to[k] = value;
}

template <class P>
class BundlePoints {
  using S = typename P::Scalar;

 public:
  BundlePoints(const SegmentTask<S>& segment, const GroupTask<S>& group)
      : segment_(segment), group_(group), bundle_(*group.bundle) {}

  void clear() {
    bundle_.count = 0;
    bundle_.piece_count = 0;
  }

  void decide(const BlockTask& task, Classified& found) {
    for (std::size_t i = 0; i < kBlock; ++i) {
      if ((found.pending >> i & 1) == 0) continue;
      const Vec3d x{task.points.x[i], task.points.y[i], task.points.z[i]};
      const void* cell = nullptr;
      const double t = segment_.next_contact(segment_.contact_data, x, static_cast<double>(segment_.begin), cell);
      if (t > 1) continue;
      task.start[i] = t;
      found.later |= std::uint64_t{1} << i;
    }
  }

  // Appends the points of a block to the bundle, in runs of neighbours.
  void append(std::size_t first, const double* start, const Classified& found) {
    const std::uint64_t taken = found.inside | found.later;
    for (std::uint64_t rest = taken; rest != 0;) {
      const auto begin = static_cast<std::size_t>(__builtin_ctzll(rest));
      const std::uint64_t gaps = ~(rest >> begin);  // shifted in zeros are gaps too
      const std::size_t count = gaps == 0 ? kBlock : static_cast<std::size_t>(__builtin_ctzll(gaps));
      append_run(first + begin, count);
      rest = begin + count == kBlock ? 0 : rest >> (begin + count) << (begin + count);
    }
    if (found.later == 0) return;
    const std::size_t lane =
        static_cast<std::size_t>(bundle_.count) - static_cast<std::size_t>(__builtin_popcountll(taken));
    for (std::uint64_t rest = found.later; rest != 0; rest &= rest - 1) {
      const std::uint64_t below = (rest & -rest) - 1;
      const std::size_t at = lane + static_cast<std::size_t>(__builtin_popcountll(taken & below));
      bundle_.t[at] = static_cast<S>(start[__builtin_ctzll(rest)]);
      bundle_.at_contact[at] = 1;
    }
  }

  // Fetches the points of a block, and their counts of steps, into the caches.
  void prefetch(std::size_t first) const {
    constexpr std::size_t kLine = 64;  // bytes
    for (const double* const from : {group_.points.x, group_.points.y, group_.points.z}) {
      for (std::size_t i = 0; i < kBlock; i += kLine / sizeof(double)) __builtin_prefetch(from + first + i, 1);
    }
    for (std::size_t i = 0; i < kBlock; i += kLine / sizeof(std::uint32_t))
      __builtin_prefetch(group_.steps + first + i, 1);
  }

  std::size_t point_of(std::size_t slot) const {
    int k = 0;
    while (slot >= bundle_.pieces[k].lane + std::size_t{bundle_.pieces[k].count}) ++k;
    return bundle_.pieces[k].point + slot - bundle_.pieces[k].lane;
  }

  // Adds the results to the points. The result of a point that has not moved is -0, which changes no bits.
  void scatter(bool in_one_step) {
    const double most = greatest_result();
    for (int k = 0; k < bundle_.piece_count; ++k) {
      const Piece& piece = bundle_.pieces[k];
      note_moved(piece.point, most);
      std::uint32_t* const steps = group_.steps + piece.point;
      with_count(piece.count, [&](std::size_t n) {
        add_to(group_.points.x + piece.point, bundle_.result[0] + piece.lane, n);
        add_to(group_.points.y + piece.point, bundle_.result[1] + piece.lane, n);
        add_to(group_.points.z + piece.point, bundle_.result[2] + piece.lane, n);
        for (std::size_t i = 0; in_one_step && i < n; ++i) ++steps[i];
      });
      for (std::size_t i = 0; !in_one_step && i < piece.count; ++i) {
        steps[i] += static_cast<std::uint32_t>(bundle_.result_steps[piece.lane + i]);
      }
    }
  }

  void note_moved(std::size_t point, double by) {
    double& moved = group_.moved[point / kBlock];
    moved = by > moved ? by : moved;
  }

 private:
  void append_run(std::size_t point, std::size_t count) {
    const auto lane = static_cast<std::size_t>(bundle_.count);
    const Vec3d center = segment_.center;
    const S begin = segment_.begin;
    with_count(count, [&](std::size_t n) {
      copy(group_.points.x + point, center.x, bundle_.base[0] + lane, n);
      copy(group_.points.y + point, center.y, bundle_.base[1] + lane, n);
      copy(group_.points.z + point, center.z, bundle_.base[2] + lane, n);
      fill(bundle_.t + lane, begin, n);
      fill(bundle_.at_contact + lane, std::uint8_t{0}, n);
    });
    for (std::size_t k = 0; segment_.kernel.by_lanes && k < count; ++k) {
      const std::size_t i = point + k;
      bundle_.origins[lane + k] = {{group_.points.x[i], group_.points.y[i], group_.points.z[i]}, nullptr};
    }
    bundle_.pieces[bundle_.piece_count++] = {static_cast<std::uint16_t>(lane), static_cast<std::uint16_t>(point),
                                             static_cast<std::uint16_t>(count)};
    bundle_.count += static_cast<int>(count);
  }

  // Calls body with the count; as a constant for whole blocks, whose loops then need no remainder.
  template <class Body>
  KNEAD_INLINE static void with_count(std::size_t count, const Body& body) {
    count == kBlock ? body(kBlock) : body(count);
  }

  KNEAD_INLINE static void copy(const double* from, double origin, S* __restrict to, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) to[k] = static_cast<S>(from[k] - origin);
  }

  KNEAD_INLINE static void add_to(double* __restrict to, const S* by, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) to[i] += static_cast<double>(by[i]);
  }

  // Returns the greatest coordinate of a result so far, a bound for each block of the group.
  double greatest_result() {
    P greatest(most_);
    const Piece& last = bundle_.pieces[bundle_.piece_count - 1];
    const std::size_t count = std::size_t{last.lane} + last.count;
    const std::size_t end = (count + P::kSize - 1) / P::kSize * P::kSize;
    for (int axis = 0; axis < 3; ++axis) {
      S* const by = bundle_.result[axis];
      fill(by + count, S(0), end - count);
      for (std::size_t i = 0; i < end; i += P::kSize) {
        const P result = P::load(by + i);
        greatest = maximum(greatest, maximum(result, -result));
      }
    }
    if (bits(greatest > P(most_)) != 0) {
      S lane[P::kSize];
      greatest.store(lane);
      for (const S size : lane) most_ = std::max(most_, size);
    }
    return static_cast<double>(most_);
  }

  const SegmentTask<S>& segment_;
  const GroupTask<S>& group_;
  Bundle<S>& bundle_;
  S most_{0};
};

template <class P>
KNEAD_INLINE auto equal(const Vec3<P>& a, const Vec3<P>& b) {
  return (a.x == b.x) & (a.y == b.y) & (a.z == b.z);
}

// Returns the used lanes of the pack at lane i.
template <class P>
KNEAD_INLINE std::uint32_t lanes_in_use(std::size_t i, int count) {
  const std::size_t rest = static_cast<std::size_t>(count) - i;
  const std::uint32_t all = static_cast<std::uint32_t>((std::uint64_t{1} << P::kSize) - 1);
  return rest >= P::kSize ? all : (std::uint32_t{1} << rest) - 1;
}

// The evaluation of a bundle's field, and the limits of its steps.
template <class P>
class BundleField {
  using S = typename P::Scalar;

 public:
  BundleField(const SegmentTask<S>& segment, Bundle<S>& bundle) : segment_(segment), bundle_(bundle) {
    if (segment.kernel.limit == nullptr) return;
    fill(limits_.speed, S(0), kBundle);
    if (!is_limited_by_place()) return;
    fill(limits_.reach, segment.reach, kBundle);
    fill(limits_.time, std::numeric_limits<S>::max(), kBundle);
  }

  std::uint64_t evaluations() const { return evaluations_; }

  // Counts the asked lanes only, so that the count of a path line depends on it alone.
  void evaluate(const Stage<S>& stage) {
    segment_.kernel.stage(segment_.field, bundle_, stage);
    evaluations_ += static_cast<std::uint64_t>(bundle_.asked.count());
  }
  void count_evaluations(int more) { evaluations_ += static_cast<std::uint64_t>(more); }

  void follow() {
    if (segment_.kernel.follow != nullptr) count_evaluations(segment_.kernel.follow(segment_.field, bundle_));
  }

  void find_limits(bool from_start) {
    if (segment_.kernel.limit != nullptr) segment_.kernel.limit(segment_.field, bundle_, from_start, limits_);
  }

  KNEAD_INLINE bool is_limited_by_place() const { return is_limited() && segment_.kernel.limits_place; }
  KNEAD_INLINE bool is_limited() const { return segment_.kernel.limit != nullptr; }
  KNEAD_INLINE P hidden_speed(std::size_t i) const { return P::load(limits_.speed + i); }
  KNEAD_INLINE P longest_time(std::size_t i) const { return P::load(limits_.time + i); }
  KNEAD_INLINE P reach(std::size_t i) const {
    return is_limited_by_place() ? P::load(limits_.reach + i) : P(segment_.reach);
  }
  KNEAD_INLINE P by_reach(std::size_t i) const {
    return is_limited_by_place() ? P(1) / P::load(limits_.reach + i) : P(S(1) / segment_.reach);
  }

  // Returns the longest step, from the slope k_0.
  KNEAD_INLINE P longest_step(std::size_t i) const {
    const Vec3<P> relative = load<P>(bundle_.k[0], i) - Vec3<P>(segment_.tool_velocity);
    P speed = maximum(norm(relative), P(segment_.tool_speed));
    if (!is_limited()) return step_rule::longest_step(speed, P(segment_.reach));
    speed = speed + hidden_speed(i);
    if (!is_limited_by_place()) return step_rule::longest_step(speed, P(segment_.reach));
    return minimum(step_rule::longest_step(speed, reach(i)), longest_time(i));
  }

  // Returns the lanes where v is 0, except those at which a tool is just arriving.
  KNEAD_INLINE std::uint32_t resting(std::size_t i) const {
    std::uint32_t rests = bits(equal(load<P>(bundle_.k[0], i), Vec3<P>{P(0), P(0), P(0)}));
    for (std::size_t k = 0; rests != 0 && k < P::kSize; ++k) {
      if (bundle_.at_contact[i + k] != 0) rests &= ~(std::uint32_t{1} << k);
    }
    return rests;
  }

  // Returns the lanes that rest in the inner region of the tool.
  KNEAD_INLINE std::uint32_t carried(std::size_t i) const {
    if (!segment_.carries) return 0;
    return bits(equal(load<P>(bundle_.k[0], i), Vec3<P>(segment_.tool_velocity)));
  }

 private:
  const SegmentTask<S>& segment_;
  Bundle<S>& bundle_;
  std::uint64_t evaluations_ = 0;
  alignas(64) StepLimits<S> limits_;
};

// Moves the path lines of a bundle through a whole segment in one step, where that is accurate (step_rule.h).
template <class P>
class WholeSegment {
  using S = typename P::Scalar;

 public:
  WholeSegment(const SegmentTask<S>& segment, Bundle<S>& bundle, BundleField<P>& field)
      : segment_(segment), bundle_(bundle), field_(field) {}

  // Tries one step of Heun's method, then one of third order with the same first two slopes (Shu and Osher 1988).
  // Writes the results of the lanes for which one of them is accurate, and returns these lanes. Keeps k_0 for the
  // others.
  LaneSet run() {
    done_.clear();
    Stage<S> stage;
    stage.from_start = true;
    bundle_.asked.fill(lanes());
    field_.evaluate(stage);
    field_.find_limits(true);
    bundle_.asked.clear();
    skips_second_order_ = true;
    for (std::size_t i = 0; i < lanes(); i += P::kSize) measure(i);
    if (bundle_.asked.count() == 0) return done_;
    stage.weights[0] = S(1);
    stage.count = 1;
    stage.c = S(1);
    stage.out = 1;
    field_.evaluate(stage);
    if (!skips_second_order_) judge<true, false>();
    if (!skips_second_order_ && bundle_.asked.count() == 0) return done_;
    stage.weights[0] = stage.weights[1] = S(0.25);
    stage.slopes[1] = 1;
    stage.count = 2;
    stage.c = S(0.5);
    stage.out = 2;
    segment_.kernel.stage(segment_.field, bundle_, stage);
    skips_second_order_ ? judge<false, true>() : judge<true, true>();
    field_.count_evaluations(bundle_.asked.count());
    return done_;
  }

 private:
  std::size_t lanes() const { return static_cast<std::size_t>(bundle_.count); }

  // Writes the rest of the segment to h, and the square of its ratio to the longest step to `trial`: a great number
  // where one step is not worth trying, or where the point rests in space or in the tool's frame, so that the slope
  // tells nothing. Asks for the lanes that are worth trying.
  KNEAD_INLINE void measure(std::size_t i) {
    const P h = P(segment_.end) - P::load(bundle_.t + i);
    h.store(bundle_.h + i);
    const Vec3<P> k = load<P>(bundle_.k[0], i);
    const P reach = field_.reach(i);
    const P by_reach = field_.by_reach(i);
    const P tool_speed = P(segment_.tool_speed) * by_reach;
    P speed2 = maximum(norm2((k - Vec3<P>(segment_.tool_velocity)) * by_reach), tool_speed * tool_speed);
    if (field_.is_limited()) {
      const P speed = mul_add(field_.hidden_speed(i), by_reach, sqrt(speed2));
      speed2 = speed * speed;
    }
    P part2 = h * h * speed2;
    const P scale = reach * P(segment_.expected_error);
    const P expected2 = step_rule::expected_third_order_error2(part2, speed2, scale * scale);
    if (field_.is_limited_by_place()) {
      const P part = h / field_.longest_time(i);
      part2 = maximum(part2, part * part);
    }
    const std::uint32_t rests = field_.resting(i) | field_.carried(i);
    part2 = select(expected2 <= P(1), part2, P(1e9));
    part2.store(bundle_.trial + i);
    const std::uint32_t used = lanes_in_use<P>(i, bundle_.count);
    const std::uint32_t near = bits(part2 <= P(kSecondOrderReach * kSecondOrderReach));
    const std::uint32_t uncertain = bits(expected2 > P(kCertainThirdOrderError * kCertainThirdOrderError));
    skips_second_order_ = skips_second_order_ && ((near | uncertain) & used) == 0;
    for (std::size_t lane = 0; rests != 0 && lane < P::kSize; ++lane) {
      if ((rests >> lane & 1) != 0) bundle_.trial[i + lane] = S(1e9);
    }
    bundle_.asked.add(i, bits(part2 <= P(kThirdOrderReach * kThirdOrderReach)) & ~rests & used);
  }

  // Finds the lanes that are accurate in the second order and, if k_2 is known, in the third. Asks for those that are
  // not accurate in the second and for which k_2 is worth an evaluation.
  template <bool with_second, bool with_third>
  void judge() {
    done_.clear();
    bundle_.asked.clear();
    const P by_tolerance(S(1) / segment_.tolerance);
    for (std::size_t i = 0; i < lanes(); i += P::kSize) {
      const Vec3<P> k0 = load<P>(bundle_.k[0], i);
      const Vec3<P> k1 = load<P>(bundle_.k[1], i);
      // Also uses the speed at the end of Euler's step, because a turning tool may be almost at rest at the beginning.
      const P h = P::load(bundle_.h + i);
      const P speed2_there = norm2((k1 - Vec3<P>(segment_.tool_velocity)) * field_.by_reach(i));
      const P part2 = maximum(P::load(bundle_.trial + i), h * h * speed2_there);
      const P one(1);
      const P zero(0);
      Vec3<P> slope = (k0 + k1) * P(0.5);
      const P change2 = norm2((k1 - slope) * by_tolerance);
      const auto promising = step_rule::third_order_outlook(change2, part2) <= one;
      auto good = promising;
      if constexpr (with_second) good = (step_rule::second_order_excess(change2, part2) <= one) & (norm2(slope) > zero);
      const std::uint32_t second = with_second ? bits(good) : 0;
      const std::uint32_t used = lanes_in_use<P>(i, bundle_.count);
      bundle_.asked.add(i, bits(promising) & ~second & used);
      std::uint32_t done = second;
      if constexpr (with_third) {
        const Vec3<P> change = (load<P>(bundle_.k[2], i) - slope) * P(2.0 / 3);
        const Vec3<P> third = slope + change;
        const P excess = step_rule::third_order_excess(norm2(change * by_tolerance), part2);
        done |= bits(promising & (excess <= one) & (norm2(third) > zero));
        slope = with_second ? select(good, slope, third) : third;
      }
      store(slope * h, bundle_.result, i);
      done_.add(i, done & used);
    }
  }

  const SegmentTask<S>& segment_;
  Bundle<S>& bundle_;
  BundleField<P>& field_;
  LaneSet done_;
  bool skips_second_order_ = false;  // evaluates the third order without judging the second
};

}  // namespace knead::detail
