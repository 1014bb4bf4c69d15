// Sums of segments: path lines side by side in the sum of the parts' velocities. Internal to the flow room: part of the
// one source of all kernels.
//
// A part evaluates to the bits that it has alone, and to exactly 0 beyond its support: whether it is evaluated there
// depends on the neighbours of a lane, its sum does not. The order of the additions is that of a butterfly, so that v
// at the mirror image of a point is the mirror image of v, to the bit, where that is so of the parts.
#pragma once

#include <limits>

#include "knead/flow/kernel_stage.h"

namespace knead::detail {

// How far a place is beyond a part's support.
template <class P, class S>
KNEAD_INLINE P gap_from(const SumPart<S>& part, const Vec3<P>& y, const P& t) {
  if (part.in_space) return dot(Vec3<P>(part.middle), y) - P(part.extent);
  const Vec3<P> d = neg_mul_add(Vec3<P>(part.by), t, y - Vec3<P>(part.middle));
  return sqrt(norm2(d)) - P(part.extent);
}

// Into bundle.own how far the lanes have moved in a stage, and when that is.
template <class P, class S>
KNEAD_INLINE void place_lanes(const Bundle<S>& bundle, const Stage<S>& stage) {
  Bundle<S>& own = *bundle.own;
  own.count = bundle.count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bundle.count); i += P::kSize) {
    Vec3<P> moved{P(0), P(0), P(0)};
    P t = P::load(bundle.t + i);
    if (!stage.from_start) moved = load<P>(bundle.moved, i);
    if (stage.count > 0) {
      const P h = P::load(bundle.h + i);
      moved = mul_add(combine<P>(bundle, stage, i), h, moved);
      t = mul_add(h, P(stage.c), t);
    }
    store(moved, own.moved, i);
    t.store(own.t + i);
  }
}

// Makes bundle.own ready for a part, and asks for the lanes that it may move. Returns whether there are any.
template <class P, class S>
KNEAD_INLINE bool ask_part(const SumPart<S>& part, const Bundle<S>& bundle) {
  Bundle<S>& own = *bundle.own;
  own.asked.clear();
  const Vec3<P> zero{P(0), P(0), P(0)};
  for (std::size_t i = 0; i < static_cast<std::size_t>(bundle.count); i += P::kSize) {
    const Vec3<P> base = load<P>(bundle.base, i);
    store(base - Vec3<P>(part.center), own.base, i);
    store(zero, own.k[0], i);
    const P gap = gap_from(part, base + load<P>(own.moved, i), P::load(own.t + i));
    own.asked.add(i, bits(gap < P(0)) & bundle.asked.bits(i, P::kSize));
  }
  if (own.asked.count() == 0) return false;
  for (std::size_t i = 0; part.kernel.by_lanes && i < static_cast<std::size_t>(bundle.count); ++i) {
    own.origins[i] = {bundle.origins[i].x0, nullptr};
  }
  return true;
}

// Into own.k[0] the part's v in the lanes that are asked for.
template <class S>
KNEAD_INLINE void evaluate_part(const SumPart<S>& part, Bundle<S>& own) {
  if (part.kernel.follow != nullptr) {
    part.kernel.follow(part.field, own);  // beyond all cells k_0 stays 0
  } else {
    part.kernel.stage(part.field, own, Stage<S>{});
  }
}

template <class P, class S>
[[gnu::flatten]] void sum_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const auto& field = *static_cast<const SumKernelField<S>*>(data);
  const auto lanes = static_cast<std::size_t>(bundle.count);
  alignas(64) Lanes3<S> slopes[kMostSummed];
  place_lanes<P>(bundle, stage);
  for (int k = 0; k < field.count; ++k) {
    if (ask_part<P>(field.parts[k], bundle)) evaluate_part(field.parts[k], *bundle.own);
    for (std::size_t i = 0; i < lanes; i += P::kSize) store(load<P>(bundle.own->k[0], i), slopes[k], i);
  }
  // Neighbours first, then pairs of them, and so on, as images in one plane, two and three follow each other. At the
  // end 0 is added: a part that was not evaluated leaves 0, one that was perhaps -0.
  for (std::size_t i = 0; i < lanes; i += P::kSize) {
    for (int stride = 1; stride < field.count; stride *= 2) {
      for (int k = 0; k + stride < field.count; k += 2 * stride) {
        store(load<P>(slopes[k], i) + load<P>(slopes[k + stride], i), slopes[k], i);
      }
    }
    store(load<P>(slopes[0], i) + Vec3<P>{P(0), P(0), P(0)}, bundle.k[stage.out], i);
  }
}

// The limits of one part's own field.
template <class P, class S>
KNEAD_INLINE void limit_part(const SumPart<S>& part, const Bundle<S>& bundle, StepLimits<S>& limits) {
  const auto lanes = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < lanes; i += P::kSize) {
    P(0).store(limits.speed + i);
    P(part.reach).store(limits.reach + i);
    P(std::numeric_limits<S>::max()).store(limits.time + i);
  }
  if (part.kernel.limit == nullptr || !ask_part<P>(part, bundle)) return;
  Bundle<S>& own = *bundle.own;
  if (part.leaves_width) part.kernel.stage(part.field, own, Stage<S>{});
  for (std::size_t i = 0; i < lanes; i += P::kSize) store(load<P>(bundle.k[0], i), own.k[0], i);
  part.kernel.limit(part.field, own, false, limits);
}

// A step is as long as the strictest part allows; a part at a distance allows that distance more. The mover divides the
// speed by the reach: it gets a speed with which that is the greatest rate of a part.
template <class P, class S>
[[gnu::flatten]] void limit_sum(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const auto& field = *static_cast<const SumKernelField<S>*>(data);
  const auto lanes = static_cast<std::size_t>(bundle.count);
  Stage<S> here;
  here.from_start = from_start;
  place_lanes<P>(bundle, here);
  alignas(64) StepLimits<S> part_limits;
  for (int k = 0; k < field.count; ++k) {
    const SumPart<S>& part = field.parts[k];
    limit_part<P>(part, bundle, part_limits);
    for (std::size_t i = 0; i < lanes; i += P::kSize) {
      const P t = P::load(bundle.own->t + i);
      const P gap = gap_from(part, load<P>(bundle.base, i) + load<P>(bundle.own->moved, i), t);
      const P reach = P::load(part_limits.reach + i) + maximum(gap, P(0));
      const P relative = sqrt(norm2(load<P>(bundle.k[0], i) - Vec3<P>(part.tool_velocity)));
      const P rate = (maximum(relative, P(part.tool_speed)) + P::load(part_limits.speed + i)) / reach;
      const P time = P::load(part_limits.time + i);
      (k == 0 ? rate : maximum(rate, P::load(limits.speed + i))).store(limits.speed + i);
      (k == 0 ? reach : minimum(reach, P::load(limits.reach + i))).store(limits.reach + i);
      (k == 0 ? time : minimum(time, P::load(limits.time + i))).store(limits.time + i);
    }
  }
  for (std::size_t i = 0; i < lanes; i += P::kSize) {
    const P speed = sqrt(norm2(load<P>(bundle.k[0], i)));
    mul_sub(P::load(limits.speed + i), P::load(limits.reach + i), speed).store(limits.speed + i);
  }
}

template <class P>
FieldKernel<typename P::Scalar> sum_kernel() {
  using S = typename P::Scalar;
  FieldKernel<S> kernel;
  kernel.stage = &sum_stage<P, S>;
  kernel.limit = &limit_sum<P, S>;
  kernel.limits_place = true;
  return kernel;
}

}  // namespace knead::detail
