// The velocity field of one tool: v = curl(w A) = w u + (dw/dr) grad r x A (method, section 1).
//
// v is divergence-free for any A, C1 where the region field is C2, the inner motion where r < inner, and exactly 0
// where r >= outer. A field is data; positions that it is evaluated at are relative to its centre.
#pragma once

#include <variant>

#include "knead/field/blend.h"
#include "knead/field/motion.h"
#include "knead/field/region.h"

namespace knead {

struct Field {
  Vec3d center;  // c at t = 0
  Motion motion;
  Region region;
  Thresholds<double> thresholds;

  friend bool operator==(const Field&, const Field&) = default;
};

// v at d = x - c(t), for one inner motion and the value of one region there. This is the one formula that everything
// evaluates.
template <class T, class M, class S>
Vec3<T> velocity_where(const RegionValue<T>& r, const M& motion, const Thresholds<S>& thresholds, const Vec3<T>& d) {
  const Weight<T> w = blend_weight(r.value, thresholds);
  const MotionValue<T> inner = evaluate(motion, d);
  return inner.velocity * w.value + cross(r.gradient, inner.potential) * w.derivative;
}

template <class T, class M, class R, class S>
Vec3<T> velocity(const M& motion, const R& region, const Thresholds<S>& thresholds, const Vec3<T>& d, const T& t) {
  return velocity_where(evaluate(region, d, t), motion, thresholds, d);
}

// v at d = x - c(t), in double.
inline Vec3d velocity(const Field& field, const Vec3d& d, double t = 0) {
  return std::visit(
      [&](const auto& motion, const auto& region) { return velocity(motion, region, field.thresholds, d, t); },
      field.motion, field.region);
}

// r at d = x - c(t), in double.
inline RegionValue<double> region_value(const Field& field, const Vec3d& d, double t = 0) {
  return std::visit([&](const auto& region) { return evaluate(region, d, t); }, field.region);
}

}  // namespace knead
