// A whole segment as one step, for the path lines of a bundle for which that is accurate (step_rule.h). Internal to the
// flow room: part of the one source of all kernels.
#pragma once

#include "knead/flow/kernel_bundle.h"

namespace knead::detail {

template <class P>
class WholeSegment {
  using S = typename P::Scalar;

 public:
  WholeSegment(const SegmentTask<S>& segment, Bundle<S>& bundle, BundleField<P>& field)
      : segment_(segment), bundle_(bundle), field_(field) {}

  // Tries one step of Heun's method, then one of third order that begins with the same two slopes (Shu and Osher 1988).
  // Writes the results of the lanes for which one of them is accurate, and returns these lanes. Leaves k_0 to the
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
    if (!skips_second_order_) judge<false>();
    if (!skips_second_order_ && bundle_.asked.count() == 0) return done_;
    stage.weights[0] = stage.weights[1] = S(0.25);
    stage.slopes[1] = 1;
    stage.count = 2;
    stage.c = S(0.5);
    stage.out = 2;
    segment_.kernel.stage(segment_.field, bundle_, stage);
    judge<true>();
    field_.count_evaluations(bundle_.asked.count());
    return done_;
  }

 private:
  std::size_t lanes() const { return static_cast<std::size_t>(bundle_.count); }

  // Into h the rest of the segment, and into `trial` the square of which part of the longest step that is: a great
  // number where one step is not worth trying, or the slope does not tell, the point being at rest in space or in the
  // tool's frame. Asks for the lanes that are worth trying.
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

  // Which lanes are accurate with k_0 and k_1, and with k_2 if that is known. Asks for those of the others for which
  // k_2 is worth an evaluation.
  template <bool with_third>
  void judge() {
    done_.clear();
    bundle_.asked.clear();
    const P by_tolerance(S(1) / segment_.tolerance);
    for (std::size_t i = 0; i < lanes(); i += P::kSize) {
      const Vec3<P> k0 = load<P>(bundle_.k[0], i);
      const Vec3<P> k1 = load<P>(bundle_.k[1], i);
      // The part by the speed at the end of Euler's step, too: at the beginning a turning tool may be all but at rest.
      const P h = P::load(bundle_.h + i);
      const P speed2_there = norm2((k1 - Vec3<P>(segment_.tool_velocity)) * field_.by_reach(i));
      const P part2 = maximum(P::load(bundle_.trial + i), h * h * speed2_there);
      const P one(1);
      const P zero(0);
      Vec3<P> slope = (k0 + k1) * P(0.5);
      const P change2 = norm2((k1 - slope) * by_tolerance);
      auto good = (step_rule::second_order_excess(change2, part2) <= one) & (norm2(slope) > zero);
      const auto promising = step_rule::third_order_outlook(change2, part2) <= one;
      const std::uint32_t used = lanes_in_use<P>(i, bundle_.count);
      bundle_.asked.add(i, bits(promising) & ~bits(good) & used);
      if constexpr (with_third) {
        const Vec3<P> change = (load<P>(bundle_.k[2], i) - slope) * P(2.0 / 3);
        const Vec3<P> third = slope + change;
        const P excess = step_rule::third_order_excess(norm2(change * by_tolerance), part2);
        slope = select_each(good, slope, third);
        good = good | (promising & (excess <= one) & (norm2(third) > zero));
      }
      store(slope * h, bundle_.result, i);
      done_.add(i, bits(good) & used);
    }
  }

  const SegmentTask<S>& segment_;
  Bundle<S>& bundle_;
  BundleField<P>& field_;
  LaneSet done_;
  bool skips_second_order_ = false;  // whether the second order need not be judged before the third is evaluated
};

}  // namespace knead::detail
