// The fields of path lines that lie side by side. Internal to the flow room: part of the one source of all kernels.
#pragma once

#include <limits>

#include "knead/field/field.h"
#include "knead/field/point_sums.h"
#include "knead/flow/kernel.h"
#include "knead/flow/pack.h"
#include "knead/flow/step_rule.h"

namespace knead::detail {

// S^(-1/m), as inverse_root of one number (field/point_set.h); every lane stops by itself.
template <class P>
requires requires { typename P::Mask; }
KNEAD_INLINE P inverse_root(const P& sum, int m) {
  P y = P(1) / sum;
  int q = 1;
  for (; 2 * q <= m; q *= 2) y = sqrt(y);
  if (q == m) return y;
  y = select(sum < P(1), sqrt(y), y);
  const P inverse(1.0 / m);
  for (int i = 0; i < 64; ++i) {
    const P next = mul_add(y * neg_mul_add(sum, integer_power(y, m), P(1)), inverse, y);
    const auto rises = next > y;
    if (bits(rises) == 0) break;
    y = select(rises, next, y);
  }
  return y;
}

template <class P, class S>
KNEAD_INLINE Vec3<P> offset_from(const SetPoints<S>& set, int i, const Vec3<P>& d) {
  return Vec3<P>(d.x - P(set.numbers[i]), d.y - P(set.numbers[set.count + i]), d.z - P(set.numbers[2 * set.count + i]));
}

template <class P, class S>
KNEAD_INLINE PowerSums<P> power_sums(const SetPoints<S>& set, const Vec3<P>& d, const P& scale2) {
  PowerSums<P> sums;
  sums.value = P(0);
  sums.gradient = {P(0), P(0), P(0)};
  for (int i = 0; i < set.count; ++i) {
    const Vec3<P> offset = offset_from(set, i, d);
    const P ratio = scale2 / norm2(offset);
    const P term = integer_power(ratio, set.exponent / 2);
    sums.value = sums.value + term;
    sums.gradient = mul_add(offset, term * ratio, sums.gradient);
  }
  return sums;
}

template <class P, class S>
KNEAD_INLINE RegionValue<P> region_of(const SetPoints<S>& set, const PowerSums<P>& sums, const P& scale) {
  const P root = inverse_root(sums.value, set.exponent);
  return {scale * root, sums.gradient * (root / (sums.value * scale))};
}

// r and grad r where lengths are measured by the least of the distances, so that nothing overflows.
template <class P, class S>
KNEAD_INLINE RegionValue<P> evaluate_near(const SetPoints<S>& set, const Vec3<P>& d) {
  P scale2 = norm2(offset_from(set, 0, d));
  for (int i = 1; i < set.count; ++i) scale2 = minimum(scale2, norm2(offset_from(set, i, d)));
  const auto off = scale2 > P(0);
  scale2 = select(off, scale2, P(1));
  const RegionValue<P> r = region_of(set, power_sums(set, d, scale2), sqrt(scale2));
  const P zero(0);
  return {select(off, r.value, zero),
          {select(off, r.gradient.x, zero), select(off, r.gradient.y, zero), select(off, r.gradient.z, zero)}};
}

// r and grad r of a set of few points, by the thresholds' length; as above for lanes where that does not do.
template <class P, class S>
KNEAD_INLINE RegionValue<P> evaluate(const SetPoints<S>& set, const Vec3<P>& d, const P& /*t*/) {
  const PowerSums<P> sums = power_sums(set, d, P(set.scale * set.scale));
  const P most(std::sqrt(std::numeric_limits<S>::max()));
  const auto good = (sums.value < most) & (sums.value > P(1) / most);
  const RegionValue<P> r = region_of(set, sums, P(set.scale));
  if (bits(!good) == 0) return r;
  const RegionValue<P> near = evaluate_near(set, d);
  return {select(good, r.value, near.value),
          {select(good, r.gradient.x, near.gradient.x), select(good, r.gradient.y, near.gradient.y),
           select(good, r.gradient.z, near.gradient.z)}};
}

template <class P>
KNEAD_INLINE Vec3<P> load(const Lanes3<typename P::Scalar>& from, std::size_t i) {
  return {P::load(from[0] + i), P::load(from[1] + i), P::load(from[2] + i)};
}

template <class P>
KNEAD_INLINE void store(const Vec3<P>& v, Lanes3<typename P::Scalar>& to, std::size_t i) {
  v.x.store(to[0] + i);
  v.y.store(to[1] + i);
  v.z.store(to[2] + i);
}

// sum_j weights_j k_(slopes_j).
template <class P, class S>
KNEAD_INLINE Vec3<P> combine(const Bundle<S>& bundle, const Stage<S>& stage, std::size_t i) {
  Vec3<P> sum = load<P>(bundle.k[stage.slopes[0]], i) * P(stage.weights[0]);
  for (int j = 1; j < stage.count; ++j) {
    sum = mul_add(load<P>(bundle.k[stage.slopes[j]], i), P(stage.weights[j]), sum);
  }
  return sum;
}

// Where the lanes of a pack are in a stage, and when.
template <class P>
struct StagePlace {
  Vec3<P> at;  // from the field's centre at t = 0
  P t;
};

template <class P, class S>
KNEAD_INLINE StagePlace<P> place_in(const Bundle<S>& bundle, const Stage<S>& stage, std::size_t i) {
  StagePlace<P> place{load<P>(bundle.base, i), P::load(bundle.t + i)};
  if (!stage.from_start) place.at = place.at + load<P>(bundle.moved, i);
  if (stage.count == 0) return place;
  const P h = P::load(bundle.h + i);
  place.at = mul_add(combine<P>(bundle, stage, i), h, place.at);
  place.t = mul_add(h, P(stage.c), place.t);
  return place;
}

// What is known of a stage before its loop over the lanes: its number of slopes where it begins at the start, or
// kAnySlopes. Only brushes have loops for the attempts to cross a whole segment: 5% to 10% of the time in float.
inline constexpr int kAnySlopes = -1;

// A stage for the default falloff, or for any. Told apart before the loop, the default costs nothing.
template <class P, class Field, bool by_default, int slopes, class S>
[[gnu::flatten]] void stage_of(const void* data, Bundle<S>& bundle, const Stage<S>& given) {
  Field field = *static_cast<const Field*>(data);  // copies: what is stored below does not change them
  Stage<S> stage = given;
  if constexpr (by_default) field.thresholds.falloff = kDefaultFalloff;
  if constexpr (slopes != kAnySlopes) {
    stage.count = slopes;
    stage.from_start = true;
  }
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    const auto [at, t] = place_in<P>(bundle, stage, i);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, at);
    store(velocity(field.motion, field.region, field.thresholds, d, t), bundle.k[stage.out], i);
  }
}

template <class P, class Field, class S>
void stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const bool by_default = static_cast<const Field*>(data)->thresholds.falloff == kDefaultFalloff;
  if (!by_default) return stage_of<P, Field, false, kAnySlopes>(data, bundle, stage);
  if constexpr (std::is_same_v<decltype(Field::motion), Translation<S>>) {
    if (stage.from_start && stage.count == 0) return stage_of<P, Field, true, 0>(data, bundle, stage);
    if (stage.from_start && stage.count == 1) return stage_of<P, Field, true, 1>(data, bundle, stage);
    if (stage.from_start && stage.count == 2) return stage_of<P, Field, true, 2>(data, bundle, stage);
  }
  stage_of<P, Field, true, kAnySlopes>(data, bundle, stage);
}

// The same under a mask.
template <class P, class Field, bool by_default, class S>
[[gnu::flatten]] void masked_stage_of(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  Field field = *static_cast<const Field*>(data);
  if constexpr (by_default) field.thresholds.falloff = kDefaultFalloff;
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    const auto [y, t] = place_in<P>(bundle, stage, i);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, y);
    const RegionValue<P> r = evaluate(field.region, d, t);
    const MaskValue<P> m = evaluate_mask(field.mask, y);
    store(masked_velocity_where(r, field.motion, field.thresholds, d, m, field.offset), bundle.k[stage.out], i);
  }
}

template <class P, class Field, class S>
void masked_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const bool by_default = static_cast<const Field*>(data)->thresholds.falloff == kDefaultFalloff;
  by_default ? masked_stage_of<P, Field, true>(data, bundle, stage)
             : masked_stage_of<P, Field, false>(data, bundle, stage);
}

// How long a step may be so that it passes no more of the mask's border than kMaskReach of its width.
template <class P, class S>
KNEAD_INLINE P longest_time_under(const MaskView<S>& mask, const Vec3<P>& y, const Vec3<P>& slope) {
  const P reach = maximum(clearance(mask, y), P(S(kMaskReach)) * P(mask.width));
  return step_rule::longest_step(sqrt(norm2(slope)), reach);
}

template <class P, class Field, class S>
[[gnu::flatten]] void limit_by_mask(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const Field field = *static_cast<const Field*>(data);
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    Vec3<P> y = load<P>(bundle.base, i);
    if (!from_start) y = y + load<P>(bundle.moved, i);
    longest_time_under(field.mask, y, load<P>(bundle.k[0], i)).store(limits.time + i);
  }
}

// |dr/dt| of a turning half-space at a resting point.
template <class P, class Field, class S>
[[gnu::flatten]] void limit_by_turning(const void* data, const Bundle<S>& bundle, bool from_start,
                                       StepLimits<S>& limits) {
  const Field field = *static_cast<const Field*>(data);
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    const P t = P::load(bundle.t + i);
    Vec3<P> at = load<P>(bundle.base, i);
    if (!from_start) at = at + load<P>(bundle.moved, i);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, at);
    const Vec3<P> n = normal_at(field.region, t);
    const P speed = P(field.region.turn_angle) * dot(cross(Vec3<P>(field.region.turn_axis), n), d);
    maximum(speed, -speed).store(limits.speed + i);
  }
}

template <class P, class Field, class S>
void limit_by_mask_and_turning(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  limit_by_mask<P, Field, S>(data, bundle, from_start, limits);
  limit_by_turning<P, Field, S>(data, bundle, from_start, limits);
}

}  // namespace knead::detail
