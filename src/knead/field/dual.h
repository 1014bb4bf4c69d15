// First-order dual numbers in three variables: a value and its gradient. Motions, regions and velocities are templates
// over the scalar of the evaluation; evaluated with dual numbers they return their derivatives too.
#pragma once

#include <cmath>

#include "knead/field/region.h"
#include "knead/math/vec3.h"

namespace knead {

struct Dual {
  double v = 0;
  Vec3d g{0, 0, 0};

  constexpr Dual() = default;
  constexpr explicit Dual(double value) : v(value) {}
  constexpr Dual(double value, const Vec3d& gradient) : v(value), g(gradient) {}

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.g + b.g}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.g - b.g}; }
  friend Dual operator-(const Dual& a) { return {-a.v, -a.g}; }
  friend Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, a.g * b.v + b.g * a.v}; }
  friend Dual operator/(const Dual& a, const Dual& b) { return {a.v / b.v, (a.g * b.v - b.g * a.v) / (b.v * b.v)}; }
  friend constexpr bool operator==(const Dual& a, const Dual& b) { return a.v == b.v; }
  friend bool operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.v > b.v; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.v >= b.v; }

  // The gradient of a length, which is 0 at the origin as that of its square is.
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.v);
    return {root, root > 0 ? a.g / (2 * root) : Vec3d{0, 0, 0}};
  }
  friend Dual select(bool mask, const Dual& a, const Dual& b) { return mask ? a : b; }
  friend Dual round_to_integer(const Dual& a) { return Dual(knead::round_to_integer(a.v)); }
  friend Dual inverse_root(const Dual& sum, int m) {
    const double y = knead::inverse_root(sum.v, m);
    return {y, sum.g * (-y / (m * sum.v))};
  }
};

// The position p, each coordinate a variable.
inline Vec3<Dual> variables(const Vec3d& p) {
  return {Dual(p.x, {1, 0, 0}), Dual(p.y, {0, 1, 0}), Dual(p.z, {0, 0, 1})};
}

inline Vec3d values(const Vec3<Dual>& a) { return {a.x.v, a.y.v, a.z.v}; }

}  // namespace knead
