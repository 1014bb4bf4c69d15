// The field in the plane (paper, section 3 and Fig. 3): v = (-p_y, p_x), p = (1 - b) e, divergence-free and C1.
#pragma once

#include <cmath>

#include "knead/field.h"

namespace knead {

template <class T>
struct Vec2 {
  T x{};
  T y{};
};

// e and its gradient about the centre.
template <class T>
struct StreamValue {
  T value{};
  Vec2<T> gradient;
};

// u = (velocity.x, velocity.y): e = v x - u y.
struct Translation2d {
  Vec2<double> velocity;
};

// u = rate (-y, x), rate in radians per unit time: e = rate (x^2 + y^2) / 2.
struct Rotation2d {
  double rate = 0;
};

// Which r is blended by: the distance from the centre, or its square, as in Fig. 3 of the paper.
enum class DiscRegion { distance, squared_distance };

template <class T>
StreamValue<T> evaluate(const Translation2d& motion, const Vec2<T>& d) {
  const T u(motion.velocity.x);
  const T v(motion.velocity.y);
  return {v * d.x - u * d.y, {v, -u}};
}

template <class T>
StreamValue<T> evaluate(const Rotation2d& motion, const Vec2<T>& d) {
  const T rate(motion.rate);
  return {rate * T(0.5) * (d.x * d.x + d.y * d.y), {rate * d.x, rate * d.y}};
}

template <class T>
struct Field2dValue {
  T potential{};     // p
  Vec2<T> velocity;  // (-p_y, p_x)
};

// p and v at d = x - c. thresholds are values of r, inner < outer.
template <class T, class M>
Field2dValue<T> evaluate_2d(const M& motion, DiscRegion region, const Thresholds<double>& thresholds,
                            const Vec2<T>& d) {
  using std::sqrt;
  const T square = d.x * d.x + d.y * d.y;
  const bool squared = region == DiscRegion::squared_distance;
  const T r = squared ? square : sqrt(square);
  const T slope = squared ? T(2) : select(square > T(0), T(1) / r, T(0));  // grad r = slope d
  const T width(thresholds.outer - thresholds.inner);
  T s = (r - T(thresholds.inner)) / width;
  s = minimum(maximum(s, T(0)), T(1));
  const T rest = T(1) - s;
  const T complement = rest * rest * (T(1) + s * (T(2) + T(3) * s));  // 1 - b
  const T derivative = T(-12) * s * s * rest / width * slope;         // d(1 - b)/dr grad r = derivative d
  const StreamValue<T> e = evaluate(motion, d);
  const T p_x = complement * e.gradient.x + derivative * d.x * e.value;
  const T p_y = complement * e.gradient.y + derivative * d.y * e.value;
  return {complement * e.value, {-p_y, p_x}};
}

}  // namespace knead
