// The velocity field of one tool: v = curl(w A) = w u + (dw/dr) grad r x A (method, section 1).
//
// v is divergence-free for any A. It is C1 where the region field is C2, equals the inner motion where r < inner, and
// is exactly 0 where r >= outer. A field is data. It is evaluated at positions relative to its centre.
#pragma once

#include <cmath>
#include <limits>
#include <type_traits>
#include <variant>

#include "knead/field/blend.h"
#include "knead/field/mask.h"
#include "knead/field/motion.h"
#include "knead/field/region.h"

namespace knead {

// An inner motion in a region around a centre, blended between the thresholds.
struct Field {
  Vec3d center;  // c at t = 0
  Motion motion;
  Region region;
  Thresholds<double> thresholds;

  friend bool operator==(const Field&, const Field&) = default;
};

// Returns v at d = x - c(t) for an inner motion and the value of a region there: the one formula that everything
// evaluates.
template <class T, class M, class S>
Vec3<T> velocity_where(const RegionValue<T>& r, const M& motion, const Thresholds<S>& thresholds, const Vec3<T>& d) {
  const Weight<T> w = blend_weight(r.value, thresholds);
  const MotionValue<T> inner = evaluate(motion, d);
  return mul_add(inner.velocity, w.value, cross(r.gradient, inner.potential) * w.derivative);
}

// Returns v under a mask: curl(m w (A - offset)) = m w u + (m dw/dr grad r + w grad m) x (A - offset).
template <class T, class M, class S>
Vec3<T> masked_velocity_where(const RegionValue<T>& r, const M& motion, const Thresholds<S>& thresholds,
                              const Vec3<T>& d, const MaskValue<T>& mask, const Vec3<S>& offset) {
  const Weight<T> w = blend_weight(r.value, thresholds);
  const MotionValue<T> inner = evaluate(motion, d);
  const Vec3<T> across = mul_add(mask.gradient, w.value, r.gradient * (w.derivative * mask.value));
  return mul_add(inner.velocity, w.value * mask.value, cross(across, inner.potential - Vec3<T>(offset)));
}

// What a ball's formula divides by at its centre, where its dividend is 0. Its square is not 0, for dual numbers.
template <class S>
inline constexpr S kLeastDistance = sizeof(S) == sizeof(float) ? S(1e-18) : S(1e-150);

// Returns the same for a ball, where r = |d|: grad r x A = d x A / r, and for translations and strains
// d x (u x d) = u |d|^2 - d (u.d).
template <class T, class M, class S>
Vec3<T> velocity(const M& motion, const Ball<S>& /*region*/, const Thresholds<S>& thresholds, const Vec3<T>& d,
                 const T& /*t*/) {
  using std::sqrt;
  const T square = norm2(d);
  const T r = sqrt(square);
  const Weight<T> w = blend_weight(r, thresholds);
  const T pull = w.derivative / maximum(r, T(kLeastDistance<S>));
  if constexpr (std::is_same_v<M, Translation<S>>) {
    if (motion.gauge == S(1)) {
      const Vec3<T> u(motion.velocity);
      const T half = pull * T(S(0.5));
      return neg_mul_add(d, half * dot(u, d), u * mul_add(half, square, w.value));
    }
  }
  const MotionValue<T> inner = evaluate(motion, d);
  if constexpr (std::is_same_v<M, Strain<S>>) {
    const Vec3<T>& u = inner.velocity;
    const T third = pull * T(S(1) / S(3));
    return neg_mul_add(d, third * dot(u, d), u * mul_add(third, square, w.value));
  }
  return mul_add(cross(d, inner.potential), pull, inner.velocity * w.value);
}

// Returns v at d = x - c(t) for any region.
template <class T, class M, class R, class S>
Vec3<T> velocity(const M& motion, const R& region, const Thresholds<S>& thresholds, const Vec3<T>& d, const T& t) {
  return velocity_where(evaluate(region, d, t), motion, thresholds, d);
}

// Returns v at d = x - c(t), in double.
inline Vec3d velocity(const Field& field, const Vec3d& d, double t = 0) {
  return std::visit(
      [&](const auto& motion, const auto& region) { return velocity(motion, region, field.thresholds, d, t); },
      field.motion, field.region);
}

// Returns r and grad r at d = x - c(t), in double.
inline RegionValue<double> region_value(const Field& field, const Vec3d& d, double t = 0) {
  return std::visit([&](const auto& region) { return evaluate(region, d, t); }, field.region);
}

}  // namespace knead
