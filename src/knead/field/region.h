// Region fields r(x): their value and gradient (method, section 2).
//
// A region field is a function of d = x - c, the position relative to the tool's centre, and of the segment's time t in
// [0, 1], which only turning half-spaces and handles use. Its values are lengths, except for handles. As for inner
// motions, S is the scalar of the stored numbers and T the scalar of the evaluation.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "knead/math/scalar.h"
#include "knead/math/sincos.h"
#include "knead/math/vec3.h"

namespace knead {

// Value and gradient of a region field at one point.
template <class T>
struct RegionValue {
  T value{};         // r
  Vec3<T> gradient;  // grad r; 0 where r is not differentiable because it is 0
};

// r = |d|.
template <class S>
struct Ball {
  template <class U>
  explicit operator Ball<U>() const {
    return {};
  }
  friend bool operator==(const Ball&, const Ball&) = default;
};

// r = distance to the segment [c - half_axis, c + half_axis]. C1; C2 except on the two planes through the ends.
template <class S>
struct Capsule {
  Vec3<S> half_axis;

  template <class U>
  explicit operator Capsule<U>() const {
    return {Vec3<U>(half_axis)};
  }
  friend bool operator==(const Capsule&, const Capsule&) = default;
};

// r = n(t).d with the unit normal n turned about the unit axis `turn_axis` by turn_angle * t radians.
template <class S>
struct HalfSpace {
  Vec3<S> normal;
  Vec3<S> turn_axis{};
  S turn_angle{0};

  template <class U>
  explicit operator HalfSpace<U>() const {
    return {Vec3<U>(normal), Vec3<U>(turn_axis), static_cast<U>(turn_angle)};
  }
  friend bool operator==(const HalfSpace&, const HalfSpace&) = default;
};

// The smooth approximate distance to isolated points and polylines, all given relative to c (Biswas and Shapiro 2004,
// with the polyline's form of the method, section 2): r = (sum_k r_k^-m)^(-1/m), m = exponent, even and at least 2; r_k
// is the distance of a point, or (3/4 integral over the polyline of |x - y|^-5 dl)^(-1/4). r = 0 exactly on every
// element. At least one element; a polyline has two or more points, of which consecutive ones differ.
template <class S>
struct PointSet {
  std::vector<Vec3<S>> points;
  std::vector<std::vector<Vec3<S>>> curves;
  int exponent = 8;

  template <class U>
  explicit operator PointSet<U>() const {
    PointSet<U> result;
    result.exponent = exponent;
    for (const Vec3<S>& p : points) result.points.emplace_back(p);
    for (const auto& curve : curves) result.curves.emplace_back(curve.begin(), curve.end());
    return result;
  }
  friend bool operator==(const PointSet&, const PointSet&) = default;
};

// Handles: r = D_full / (D_full + D_zero), a ratio and not a length: exactly 0 on the full set and exactly 1 on the
// zero set (method, section 2). The two sets have no point in common. D is the smooth distance from a point set. Both
// sets are given relative to c at t = 0. The full set follows the motion: it has moved by t * sweep (sweep is the
// segment's displacement) and turned about the unit axis through c by turn_angle * t radians. The zero set rests in
// space. The thresholds are 0 and 1; the outer region is the zero set alone. Set: how the points are stored.
template <class S, class Set = PointSet<S>>
struct Handles {
  Set full;
  Set zero;
  Vec3<S> sweep{};
  Vec3<S> turn_axis{};
  S turn_angle{0};

  template <class U>
  explicit operator Handles<U>() const {
    return {static_cast<PointSet<U>>(full), static_cast<PointSet<U>>(zero), Vec3<U>(sweep), Vec3<U>(turn_axis),
            static_cast<U>(turn_angle)};
  }
  friend bool operator==(const Handles&, const Handles&) = default;
};

// A region of the caller's own: `evaluate` returns r and grad r at d = x - c and the segment's time t, in double. The
// field is C1 if r is C2. `slope` is an upper bound of |grad r|, `speed` one of |dr/dt| at fixed d; they bound the time
// at which the tool reaches a resting point. The function is called from several threads at once.
struct CustomRegion {
  std::shared_ptr<const std::function<RegionValue<double>(const Vec3d& d, double t)>> evaluate;
  double slope = 1;
  double speed = 0;

  friend bool operator==(const CustomRegion&, const CustomRegion&) = default;
};

// Makes a CustomRegion from a function or lambda of d and t.
inline CustomRegion custom_region(std::function<RegionValue<double>(const Vec3d& d, double t)> evaluate,
                                  double slope = 1, double speed = 0) {
  using Function = std::function<RegionValue<double>(const Vec3d&, double)>;
  return {std::make_shared<const Function>(std::move(evaluate)), slope, speed};
}

// Any region.
using Region =
    std::variant<Ball<double>, Capsule<double>, HalfSpace<double>, PointSet<double>, Handles<double>, CustomRegion>;

// Returns |d| and its gradient, which is 0 at d = 0.
template <class T>
RegionValue<T> distance_to_origin(const Vec3<T>& d) {
  using std::sqrt;
  const T square = norm2(d);
  const T r = sqrt(square);
  const T inverse = select(square > T(0), T(1) / r, T(0));
  return {r, d * inverse};
}

// Returns r and grad r of the ball at d = x - c.
template <class T, class S>
RegionValue<T> evaluate(const Ball<S>& /*region*/, const Vec3<T>& d, const T& /*t*/) {
  return distance_to_origin(d);
}

// Returns r and grad r of the capsule at d = x - c.
template <class T, class S>
RegionValue<T> evaluate(const Capsule<S>& region, const Vec3<T>& d, const T& /*t*/) {
  const S length2 = norm2(region.half_axis);
  const Vec3<T> h(region.half_axis);
  const T inverse(length2 > S(0) ? S(1) / length2 : S(0));
  const T along = minimum(maximum(dot(h, d) * inverse, T(-1)), T(1));
  return distance_to_origin(d - h * along);
}

// Returns v turned about the unit axis by the angle of sc (Rodrigues' formula).
template <class T>
Vec3<T> rotate(const Vec3<T>& v, const Vec3<T>& axis, const SinCos<T>& sc) {
  return mul_add(v, sc.cos, mul_add(cross(axis, v), sc.sin, axis * (dot(axis, v) * (T(1) - sc.cos))));
}

// Returns n(t) of a half-space.
template <class T, class S>
Vec3<T> normal_at(const HalfSpace<S>& region, const T& t) {
  if (region.turn_angle == S(0)) return Vec3<T>(region.normal);
  const T angle = t * T(region.turn_angle);
  const bool small = region.turn_angle <= S(0.785) && region.turn_angle >= S(-0.785);
  return rotate(Vec3<T>(region.normal), Vec3<T>(region.turn_axis), small ? small_sincos(angle) : sincos(angle));
}

// Returns r and grad r of the half-space at d = x - c and the time t.
template <class T, class S>
RegionValue<T> evaluate(const HalfSpace<S>& region, const Vec3<T>& d, const T& t) {
  const Vec3<T> n = normal_at(region, t);
  return {dot(n, d), n};
}

// Defined in point_set.h.
template <class T, class S>
RegionValue<T> evaluate(const PointSet<S>& region, const Vec3<T>& d, const T& t);

// Defined in handles_region.h.
template <class T, class S, class Set>
RegionValue<T> evaluate(const Handles<S, Set>& region, const Vec3<T>& d, const T& t);

// Returns r and grad r of the caller's region at d = x - c and the time t.
template <std::floating_point T>
RegionValue<T> evaluate(const CustomRegion& region, const Vec3<T>& d, const T& t) {
  const RegionValue<double> value = (*region.evaluate)(Vec3d(d), static_cast<double>(t));
  return {static_cast<T>(value.value), Vec3<T>(value.gradient)};
}

}  // namespace knead

#include "knead/field/handles_region.h"
#include "knead/field/point_set.h"
