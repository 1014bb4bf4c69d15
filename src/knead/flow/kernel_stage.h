// The fields of path lines that lie side by side. Internal to the flow room: part of the one source of all kernels.
#pragma once

#include "knead/field/field.h"
#include "knead/flow/kernel.h"
#include "knead/flow/pack.h"

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

// r and grad r of a set of few points; lengths are measured by the least of the distances, so that nothing overflows.
template <class P, class S>
KNEAD_INLINE RegionValue<P> evaluate(const SetPoints<S>& set, const Vec3<P>& d, const P& /*t*/) {
  const auto offset_of = [&](int i) {
    return Vec3<P>(d.x - P(set.numbers[i]), d.y - P(set.numbers[set.count + i]), d.z - P(set.numbers[2 * set.count + i]));
  };
  P scale2 = norm2(offset_of(0));
  for (int i = 1; i < set.count; ++i) scale2 = minimum(scale2, norm2(offset_of(i)));
  const auto off = scale2 > P(0);
  scale2 = select(off, scale2, P(1));
  P sum(0);
  Vec3<P> gradient{P(0), P(0), P(0)};
  for (int i = 0; i < set.count; ++i) {
    const Vec3<P> offset = offset_of(i);
    const P ratio = scale2 / norm2(offset);
    const P term = integer_power(ratio, set.exponent / 2);
    sum = sum + term;
    gradient = mul_add(offset, term * ratio, gradient);
  }
  const P root = inverse_root(sum, set.exponent);
  const P scale = sqrt(scale2);
  const P slope = root / (sum * scale);
  return {select(off, scale * root, P(0)),
          {select(off, gradient.x * slope, P(0)), select(off, gradient.y * slope, P(0)),
           select(off, gradient.z * slope, P(0))}};
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

template <class P, class Field, class S>
[[gnu::flatten]] void stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const Field field = *static_cast<const Field*>(data);  // a copy: what is stored below does not change it
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::size) {
    P t = P::load(bundle.t + i);
    Vec3<P> d = load<P>(bundle.base, i);
    if (!stage.from_start) d = d + load<P>(bundle.moved, i);
    if (stage.count > 0) {
      const P h = P::load(bundle.h + i);
      d = mul_add(combine<P>(bundle, stage, i), h, d);
      t = mul_add(h, P(stage.c), t);
    }
    d = neg_mul_add(Vec3<P>(field.displacement), t, d);
    store(velocity(field.motion, field.region, field.thresholds, d, t), bundle.k[stage.out], i);
  }
}

// |dr/dt| of a turning half-space at a resting point.
template <class P, class Field, class S>
[[gnu::flatten]] void turning_speed(const void* data, const Bundle<S>& bundle, bool from_start, S* speeds) {
  const Field field = *static_cast<const Field*>(data);
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::size) {
    const P t = P::load(bundle.t + i);
    Vec3<P> at = load<P>(bundle.base, i);
    if (!from_start) at = at + load<P>(bundle.moved, i);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, at);
    const Vec3<P> n = normal_at(field.region, t);
    const P speed = P(field.region.turn_angle) * dot(cross(Vec3<P>(field.region.turn_axis), n), d);
    maximum(speed, -speed).store(speeds + i);
  }
}

}  // namespace knead::detail
