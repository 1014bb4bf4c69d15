// v of some fields (knead/field.h) in fewer operations than by the general formula. Internal: part of the one source of
// all kernels.
#pragma once

#include <type_traits>

#include "flow/kernels/pack.h"
#include "knead/field.h"

namespace knead::detail {

// The coefficients of a motion about an axis a: with h = a.d, d_perp = d - h a and n = grad r,
// v = (p a + q n) x d_perp + s (n x a).
template <class P>
struct TurnParts {
  P p;
  P q;
  P s;
};

template <class P, class S>
KNEAD_INLINE TurnParts<P> turn_parts(const Rotation<S>& motion, const Weight<P>& w, const P& h, const P& rho2) {
  const S rest = S(1) - motion.gauge;
  const bool radial = motion.zero_gauge == RotationGauge::radial;
  const S across = motion.rate * (motion.gauge * S(0.5) + (radial ? rest : S(0)));
  const S along_rho = motion.rate * (-motion.gauge * S(0.25) - (radial ? S(0) : rest * S(0.5)));
  const S along_height = motion.rate * (radial ? rest : S(0));
  const P along = mul_add(rho2, P(along_rho), h * h * P(along_height));
  return {w.value * P(motion.rate), w.derivative * (h * P(across)), w.derivative * along};
}

template <class P, class S>
KNEAD_INLINE TurnParts<P> turn_parts(const Twist<S>& motion, const Weight<P>& w, const P& h, const P& rho2) {
  const S across = motion.rate * motion.gauge * S(0.25);
  const S along = motion.rate * (-motion.gauge * S(0.25) - (S(1) - motion.gauge) * S(0.5));
  const P slope = w.derivative * h;
  return {w.value * (h * P(motion.rate)), slope * (h * P(across)), slope * (rho2 * P(along))};
}

template <class M, class S>
inline constexpr bool kTurns = std::is_same_v<M, Rotation<S>> || std::is_same_v<M, Twist<S>>;

template <class P, class M, class S>
requires kTurns<M, S> Vec3<P> velocity(const M& motion, const HalfSpace<S>& region, const Thresholds<S>& thresholds,
                                       const Vec3<P>& d, const P& t) {
  const Vec3<P> n = normal_at(region, t);
  const Vec3<P> a(motion.axis);
  const P h = dot(a, d);
  const Vec3<P> d_perp = neg_mul_add(a, h, d);
  const TurnParts<P> parts = turn_parts(motion, blend_weight(dot(n, d), thresholds), h, norm2(d_perp));
  const Vec3<P> across = region.turn_angle == S(0) ? Vec3<P>(cross(region.normal, motion.axis)) : cross(n, a);
  return mul_add(across, parts.s, cross(mul_add(n, parts.q, a * parts.p), d_perp));
}

// Returns d relative to the nearest point of the capsule's axis.
template <class P, class S>
KNEAD_INLINE Vec3<P> from_axis(const Capsule<S>& region, const Vec3<P>& d) {
  const S length2 = norm2(region.half_axis);
  const Vec3<P> by_length(region.half_axis * (length2 > S(0) ? S(1) / length2 : S(0)));
  const P along = minimum(maximum(dot(by_length, d), P(-1)), P(1));
  return neg_mul_add(Vec3<P>(region.half_axis), along, d);
}

// The potential of a translation is linear in d.
template <class P, class S>
Vec3<P> velocity(const Translation<S>& motion, const Capsule<S>& region, const Thresholds<S>& thresholds,
                 const Vec3<P>& d, const P& /*t*/) {
  const Vec3<S> parallel = motion.axis * dot(motion.axis, motion.velocity);
  const Vec3<S> perpendicular = motion.velocity - parallel;
  const Vec3<S> half = (parallel + perpendicular * motion.gauge) * S(0.5);
  const Vec3<S> across = cross(motion.axis, perpendicular) * (S(1) - motion.gauge);
  const Vec3<S>& a = motion.axis;
  const Vec3<P> row0(Vec3<S>{S(0), -half.z, half.y} + across * a.x);
  const Vec3<P> row1(Vec3<S>{half.z, S(0), -half.x} + across * a.y);
  const Vec3<P> row2(Vec3<S>{-half.y, half.x, S(0)} + across * a.z);
  const Vec3<P> potential{dot(row0, d), dot(row1, d), dot(row2, d)};
  const Vec3<P> from = from_axis(region, d);
  const P r = sqrt(norm2(from));
  const Weight<P> w = blend_weight(r, thresholds);
  const P pull = w.derivative / maximum(r, P(kMinDistance<S>));
  return mul_add(cross(from, potential), pull, Vec3<P>(motion.velocity) * w.value);
}

}  // namespace knead::detail
