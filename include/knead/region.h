// Region fields r(x): their value and gradient (method, section 2).
//
// A region field is a function of d = x - c, the position relative to the tool's centre, and of the segment's time t in
// [0, 1], which only turning half-spaces and handles use. Its values are lengths, except for handles. As for inner
// motions, S is the scalar of the stored numbers and T the scalar of the evaluation.
#pragma once

#include <cmath>
#include <concepts>
#include <functional>
#include <limits>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "knead/vec.h"

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

// Handles: r = D_full / (D_full + D_zero), a ratio and not a length: exactly 0 on the moving set `full` and exactly 1
// on the fixed set `zero` (method, section 2). The two sets have no point in common. D is the smooth distance from a
// point set. Both sets are given relative to c at t = 0. The moving set has moved by t * sweep (sweep is the segment's
// displacement) and turned about the unit axis through c by turn_angle * t radians. The fixed set rests in space. The
// thresholds are 0 and 1; the outer region is the fixed set alone. Set: how the points are stored.
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

// Returns r and grad r of the caller's region at d = x - c and the time t.
template <std::floating_point T>
RegionValue<T> evaluate(const CustomRegion& region, const Vec3<T>& d, const T& t) {
  const RegionValue<double> value = (*region.evaluate)(Vec3d(d), static_cast<double>(t));
  return {static_cast<T>(value.value), Vec3<T>(value.gradient)};
}

// D and its gradient for the moving set `full` and the fixed set `zero` of handles.
template <class T>
struct HandlesDistances {
  RegionValue<T> full;
  RegionValue<T> zero;
};

// Returns both distances at d = x - c(t). The moving set has turned, so d is turned back into its frame. The fixed set
// lies t * sweep behind c(t).
template <class T, class S, class Set>
HandlesDistances<T> handles_distances(const Handles<S, Set>& region, const Vec3<T>& d, const T& t) {
  const RegionValue<T> zero = evaluate(region.zero, d + Vec3<T>(region.sweep) * t, t);
  if (region.turn_angle == S(0)) return {evaluate(region.full, d, t), zero};
  const Vec3<T> axis(region.turn_axis);
  const SinCos<T> forth = sincos(t * T(region.turn_angle));
  RegionValue<T> full = evaluate(region.full, rotate(d, axis, SinCos<T>{-forth.sin, forth.cos}), t);
  full.gradient = rotate(full.gradient, axis, forth);
  return {full, zero};
}

// Returns r = F / (F + Z) and grad r = (Z grad F - F grad Z) / (F + Z)^2, with F = D_full and Z = D_zero. F and Z are
// not smooth at their points, but dw/dr is 0 there: it falls with the square of r and the cube of 1 - r. In single
// precision both distances may be 0 where points of the two sets nearly coincide; r is 1 there.
template <class T>
RegionValue<T> region_between(const HandlesDistances<T>& distance) {
  const T& full = distance.full.value;
  const T& zero = distance.zero.value;
  const T sum = full + zero;
  const auto apart = sum > T(0);
  const T inverse = select(apart, T(1) / sum, T(0));
  const Vec3<T> gradient =
      (distance.full.gradient * (zero * inverse) - distance.zero.gradient * (full * inverse)) * inverse;
  return {select(apart, full / sum, T(1)), gradient};
}

// Returns r and grad r of the handles at d = x - c(t) and the time t.
template <class T, class S, class Set>
RegionValue<T> evaluate(const Handles<S, Set>& region, const Vec3<T>& d, const T& t) {
  return region_between(handles_distances(region, d, t));
}

// Returns S^(-1/m) for S > 0: by square roots where m is a power of two, else by Newton's method, which rises
// monotonically from S^(-1/q) with q the largest power of two below m, or the smallest above where S < 1.
template <std::floating_point T>
T inverse_root(T sum, int m) {
  T y = T(1) / sum;
  int q = 1;
  for (; 2 * q <= m; q *= 2) y = std::sqrt(y);
  if (q == m) return y;
  if (sum < T(1)) y = std::sqrt(y);
  const T inverse = T(1) / static_cast<T>(m);
  for (int i = 0; i < 64; ++i) {
    const T next = y + y * (T(1) - sum * integer_power(y, m)) * inverse;
    if (!(next > y)) break;
    y = next;
  }
  return y;
}

// Returns the squared distance of d from the segment [a, b].
template <class T, class S>
T squared_distance_to_segment(const Vec3<T>& d, const Vec3<S>& a, const Vec3<S>& b) {
  const Vec3<S> e = b - a;
  const Vec3<T> from_a = d - Vec3<T>(a);
  const S length2 = norm2(e);
  const T divisor(length2 > S(0) ? length2 : S(1));
  const T along = minimum(maximum(dot(Vec3<T>(e), from_a) / divisor, T(0)), T(1));
  return norm2(from_a - Vec3<T>(e) * along);
}

// The integral of |x - y|^-5 dl over one segment, and its gradient.
template <class T>
struct CurveIntegral {
  T value{0};
  Vec3<T> gradient{T(0), T(0), T(0)};
};

// Returns the integral for x at `from_a` of the segment's first end, the unit direction e and the length of the
// segment. In the notation of the method: h the distance from the line, l_i the signed offsets of the ends from the
// foot of x, R_i the distances from the ends, u_i = l_i / R_i; D = (u2 - u1)/h^2 and G = (1 - u1 u2)/h^2 in forms that
// do not cancel; then
//   integral |x-y|^-5 dl = D (1/R1^2 + 1/R2^2 + G) / 3,
//   integral |x-y|^-7 dl = D (3/R1^4 + 3/R2^4 + 2 G^2 + 1/(R1 R2)^2 + 3 G (1/R1^2 + 1/R2^2)) / 15,
// the second found in the same way as the first; the gradient is (R1^-5 - R2^-5) e - 5 (integral of |x-y|^-7) h_vector.
template <class T>
CurveIntegral<T> segment_integral(const Vec3<T>& from_a, const Vec3<T>& e, const T& length) {
  using std::sqrt;
  const T foot = dot(e, from_a);
  const Vec3<T> h_vector = from_a - e * foot;
  const T h2 = norm2(h_vector);
  const T l1 = -foot;
  const T l2 = length - foot;
  const T i1 = T(1) / (h2 + l1 * l1);  // 1/R1^2
  const T i2 = T(1) / (h2 + l2 * l2);
  const T r1 = sqrt(h2 + l1 * l1);
  const T r2 = sqrt(h2 + l2 * l2);
  const T product = r1 * r2;
  const auto one_sign = l1 * l2 >= T(0);
  const T d_same = (l2 * l2 - l1 * l1) / (product * (l2 * r1 + l1 * r2));
  const T g_same = (h2 + l1 * l1 + l2 * l2) / (product * (product + l1 * l2));
  const T d_other = (l2 * r1 - l1 * r2) / (h2 * product);
  const T g_other = (product - l1 * l2) / (h2 * product);
  const T difference = select(one_sign, d_same, d_other);
  const T g = select(one_sign, g_same, g_other);
  const T five = difference * (i1 + i2 + g) * T(1.0 / 3.0);
  const T seven =
      difference * (T(3) * (i1 * i1 + i2 * i2) + T(2) * g * g + i1 * i2 + T(3) * g * (i1 + i2)) * T(1.0 / 15.0);
  const T ends = i1 * i1 / r1 - i2 * i2 / r2;
  return {five, e * ends - h_vector * (T(5) * seven)};
}

// Returns the squared true distance of d from the polyline.
template <class T, class S>
T squared_distance_to_curve(const Vec3<T>& d, const std::vector<Vec3<S>>& curve) {
  T least = squared_distance_to_segment(d, curve[0], curve[1]);
  for (std::size_t i = 1; i + 1 < curve.size(); ++i) {
    least = minimum(least, squared_distance_to_segment(d, curve[i], curve[i + 1]));
  }
  return least;
}

// Returns r_k and grad r_k of one polyline. Lengths are divided by the true distance first, so that nothing overflows.
template <class T, class S>
RegionValue<T> curve_distance(const Vec3<T>& d, const std::vector<Vec3<S>>& curve) {
  using std::sqrt;
  const T true_distance = sqrt(squared_distance_to_curve(d, curve));
  const T scale = select(true_distance > T(0), T(1) / true_distance, T(0));
  CurveIntegral<T> sum;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const Vec3<S> edge = curve[i + 1] - curve[i];
    const S length = norm(edge);
    if (length == S(0)) continue;  // two points that differ in double only
    const Vec3<T> from_a = (d - Vec3<T>(curve[i])) * scale;
    const CurveIntegral<T> part = segment_integral(from_a, Vec3<T>(edge / length), T(length) * scale);
    sum.value = sum.value + part.value;
    sum.gradient = sum.gradient + part.gradient;
  }
  const T inverse_scaled = sqrt(sqrt(T(0.75) * sum.value));
  const T scaled = T(1) / inverse_scaled;
  const auto is_apart = true_distance > T(0);
  const T slope = select(is_apart, T(-0.25) * scaled / sum.value, T(0));
  return {select(is_apart, scaled * true_distance, T(0)),
          select(is_apart, sum.gradient * slope, Vec3<T>{T(0), T(0), T(0)})};
}

// Returns the smallest r_k of all elements.
template <class T, class S>
T least_element_distance(const PointSet<S>& region, const Vec3<T>& d, const std::vector<RegionValue<T>>& curves) {
  using std::sqrt;
  T least2 = T(std::numeric_limits<S>::max());
  for (const Vec3<S>& p : region.points) least2 = minimum(least2, norm2(d - Vec3<T>(p)));
  T least = sqrt(least2);
  for (const RegionValue<T>& curve : curves) least = minimum(least, curve.value);
  return least;
}

// Returns r and grad r of the point set at d = x - c.
template <class T, class S>
RegionValue<T> evaluate(const PointSet<S>& region, const Vec3<T>& d, const T& /*t*/) {
  std::vector<RegionValue<T>> curves;
  for (const auto& curve : region.curves) curves.push_back(curve_distance(d, curve));
  const T least = least_element_distance(region, d, curves);
  const auto is_apart = least > T(0);
  const T inverse = select(is_apart, T(1) / least, T(0));
  T sum(0);
  Vec3<T> gradient{T(0), T(0), T(0)};  // of sum / -m, times r_min^2
  for (const Vec3<S>& p : region.points) {
    const Vec3<T> offset = (d - Vec3<T>(p)) * inverse;
    const T ratio = T(1) / norm2(offset);
    const T term = integer_power(ratio, region.exponent / 2);
    sum = sum + term;
    gradient = gradient + offset * (term * ratio);
  }
  for (const RegionValue<T>& curve : curves) {
    const T ratio = least / curve.value;
    const T term = integer_power(ratio, region.exponent);
    sum = sum + term;
    gradient = gradient + curve.gradient * (term * ratio);
  }
  const T root = inverse_root(sum, region.exponent);
  const T slope = root / sum;
  return {select(is_apart, least * root, T(0)), select(is_apart, gradient * slope, Vec3<T>{T(0), T(0), T(0)})};
}

}  // namespace knead
