// How the region field of a point set is evaluated; included by region.h.
#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include "knead/field/region.h"

namespace knead {

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
  const auto off = true_distance > T(0);
  const T slope = select(off, T(-0.25) * scaled / sum.value, T(0));
  const Vec3<T> zero{T(0), T(0), T(0)};
  const Vec3<T> gradient = sum.gradient * slope;
  return {select(off, scaled * true_distance, T(0)),
          {select(off, gradient.x, zero.x), select(off, gradient.y, zero.y), select(off, gradient.z, zero.z)}};
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

template <class T, class S>
RegionValue<T> evaluate(const PointSet<S>& region, const Vec3<T>& d, const T& /*t*/) {
  std::vector<RegionValue<T>> curves;
  for (const auto& curve : region.curves) curves.push_back(curve_distance(d, curve));
  const T least = least_element_distance(region, d, curves);
  const auto off = least > T(0);
  const T inverse = select(off, T(1) / least, T(0));
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
  const Vec3<T> scaled = gradient * slope;
  return {select(off, least * root, T(0)),
          {select(off, scaled.x, T(0)), select(off, scaled.y, T(0)), select(off, scaled.z, T(0))}};
}

}  // namespace knead
