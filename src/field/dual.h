// First-order dual numbers: a value and its gradient. Motions, regions and velocities are templates over the scalar;
// with dual numbers they also return their derivatives.
#pragma once

#include <cmath>
#include <type_traits>

#include "knead/field.h"
#include "knead/region.h"
#include "knead/vec.h"

namespace knead {

// T: a number or a pack. G: the derivatives, by default with respect to three variables; T for one variable.
template <class T, class G = Vec3<T>>
struct DualOf {
  T v{};
  G g{};

  constexpr DualOf() = default;
  constexpr explicit DualOf(const T& value) : v(value) {}
  constexpr DualOf(const T& value, const G& gradient) : v(value), g(gradient) {}
  template <class U>
  requires std::is_arithmetic_v<U>
  constexpr explicit DualOf(U value) : v(T(value)) {}
  template <class Number>  // of a field, with its derivatives
  requires std::is_constructible_v<G, const Number&> && requires(const Number& number) { number.g; }
  constexpr explicit DualOf(const Number& number) : v(T(number.v)), g(number) {}

  friend DualOf operator+(const DualOf& a, const DualOf& b) { return {a.v + b.v, a.g + b.g}; }
  friend DualOf operator-(const DualOf& a, const DualOf& b) { return {a.v - b.v, a.g - b.g}; }
  friend DualOf operator-(const DualOf& a) { return {-a.v, -a.g}; }
  friend DualOf operator*(const DualOf& a, const DualOf& b) { return {a.v * b.v, mul_add(a.g, b.v, b.g * a.v)}; }
  friend DualOf operator/(const DualOf& a, const DualOf& b) {
    const T quotient = a.v / b.v;
    return {quotient, neg_mul_add(b.g, quotient, a.g) * (T(1) / b.v)};
  }
  friend constexpr auto operator==(const DualOf& a, const DualOf& b) { return a.v == b.v; }
  friend auto operator<(const DualOf& a, const DualOf& b) { return a.v < b.v; }
  friend auto operator>(const DualOf& a, const DualOf& b) { return a.v > b.v; }
  friend auto operator>=(const DualOf& a, const DualOf& b) { return a.v >= b.v; }

  // The gradient of a length is 0 at the origin, like that of its square.
  friend DualOf sqrt(const DualOf& a) {
    using std::sqrt;
    const T root = sqrt(a.v);
    return {root, a.g * select(root > T(0), T(0.5) / root, T(0))};
  }
  template <class Mask>
  friend DualOf select(const Mask& mask, const DualOf& a, const DualOf& b) {
    return {select(mask, a.v, b.v), select(mask, a.g, b.g)};
  }
  friend DualOf round_to_integer(const DualOf& a) { return DualOf(round_to_integer(a.v)); }
  friend DualOf inverse_root(const DualOf& sum, int m) {
    const T y = inverse_root(sum.v, m);
    return {y, sum.g * (-y / (T(m) * sum.v))};
  }
};

using Dual = DualOf<double>;

// Returns w and dw/dr by the chain rule: both are functions of one number.
template <class T, class S>
Weight<DualOf<T>> blend_weight(const DualOf<T>& r, const Thresholds<S>& thresholds) {
  const Weight<DualOf<T, T>> w = blend_weight(DualOf<T, T>(r.v, T(1)), thresholds);
  return {{w.value.v, r.g * w.value.g}, {w.derivative.v, r.g * w.derivative.g}};
}

// Returns the position p, each coordinate a variable.
template <class T>
Vec3<DualOf<T>> variables(const Vec3<T>& p) {
  const T zero(0);
  const T one(1);
  return {{p.x, {one, zero, zero}}, {p.y, {zero, one, zero}}, {p.z, {zero, zero, one}}};
}

// Returns a without its derivatives.
template <class T>
Vec3<T> values(const Vec3<DualOf<T>>& a) {
  return {a.x.v, a.y.v, a.z.v};
}

}  // namespace knead
