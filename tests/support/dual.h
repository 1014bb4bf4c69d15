// First-order dual numbers in three variables: a value and its gradient. For tests of derivatives.
#pragma once

#include <cmath>

#include "knead/field/region.h"
#include "knead/math/vec3.h"

namespace knead::test {

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

  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.v);
    return {root, a.g / (2 * root)};
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

inline double divergence(const Vec3<Dual>& a) { return a.x.g.x + a.y.g.y + a.z.g.z; }

inline Vec3d curl(const Vec3<Dual>& a) { return {a.z.g.y - a.y.g.z, a.x.g.z - a.z.g.x, a.y.g.x - a.x.g.y}; }

// The greatest absolute entry of the Jacobian.
inline double jacobian_size(const Vec3<Dual>& a) {
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) size = std::fmax(size, std::abs(a[i].g[j]));
  }
  return size;
}

inline double jacobian_difference(const Vec3<Dual>& a, const Vec3<Dual>& b) {
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) size = std::fmax(size, std::abs(a[i].g[j] - b[i].g[j]));
  }
  return size;
}

}  // namespace knead::test
