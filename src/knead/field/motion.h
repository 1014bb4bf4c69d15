// Inner motions: the velocity u of the inner region and a vector potential A with curl A = u (method, section 1).
//
// An inner motion is a function of d = x - c, the position relative to the tool's centre. Adding a gradient to A does
// not change u, but changes the flow in the intermediate region: `gauge` = lambda selects A = lambda A_1 + (1 - lambda)
// A_0. A_1 = (e grad f - f grad e)/2 is that of the paper's scalar fields e and f; A_0 makes less of the flow run along
// or against the axis. S is the scalar of the stored numbers, T that of the evaluation: S, a dual number or a SIMD
// pack.
#pragma once

#include <functional>
#include <memory>
#include <variant>

#include "knead/math/mat3.h"
#include "knead/math/vec3.h"

namespace knead {

// Velocity and vector potential at one point.
template <class T>
struct MotionValue {
  Vec3<T> velocity;   // u
  Vec3<T> potential;  // A, curl A = u
};

// u = velocity (paper, Eq. 6). A_1 = u x d / 2. With a unit `axis` (a capsule's) A_0 = u_par x d / 2 + ((a x u_perp).d)
// a. The axis is not used if gauge is 1.
template <class S>
struct Translation {
  Vec3<S> velocity;
  Vec3<S> axis{};
  S gauge{1};

  template <class U>
  explicit operator Translation<U>() const {
    return {Vec3<U>(velocity), Vec3<U>(axis), static_cast<U>(gauge)};
  }
  friend bool operator==(const Translation&, const Translation&) = default;
};

// The A_0 of a rotation:
//   radial: omega (a.d) d, for a ball: no counter-rotation at all;
//   axial:  -omega/2 |d_perp|^2 a, for a bend: nothing flows along the axis.
enum class RotationGauge { radial, axial };

// u = rate axis x d (paper, Eq. 7, where the rate is 2); rate in radians per unit time, axis a unit vector.
// A_1 = rate/2 ((a.d) d_perp - |d_perp|^2 a / 2).
template <class S>
struct Rotation {
  Vec3<S> axis;
  S rate{0};
  S gauge{1};
  RotationGauge zero_gauge = RotationGauge::axial;

  template <class U>
  explicit operator Rotation<U>() const {
    return {Vec3<U>(axis), static_cast<U>(rate), static_cast<U>(gauge), zero_gauge};
  }
  friend bool operator==(const Rotation&, const Rotation&) = default;
};

// u = rate (a.d) a x d (paper, section 4.5, where the rate is 4); rate in radians per length and unit time.
// A_1 = rate/4 ((a.d)^2 d_perp - |d_perp|^2 (a.d) a), A_0 = -rate/2 (a.d) |d_perp|^2 a.
template <class S>
struct Twist {
  Vec3<S> axis;
  S rate{0};
  S gauge{1};

  template <class U>
  explicit operator Twist<U>() const {
    return {Vec3<U>(axis), static_cast<U>(rate), static_cast<U>(gauge)};
  }
  friend bool operator==(const Twist&, const Twist&) = default;
};

// u = matrix d, matrix traceless; A = (u x d) / 3.
template <class S>
struct Strain {
  Mat3<S> matrix;

  template <class U>
  explicit operator Strain<U>() const {
    return {Mat3<U>(matrix)};
  }
  friend bool operator==(const Strain&, const Strain&) = default;
};

// An inner motion of the caller's own: `evaluate` returns u and A at d = x - c, in double. The caller guarantees
// curl A = u; the resulting field is divergence-free for any A. The function is called from several threads at once.
struct CustomMotion {
  std::shared_ptr<const std::function<MotionValue<double>(const Vec3d& d)>> evaluate;

  friend bool operator==(const CustomMotion&, const CustomMotion&) = default;
};

// Any inner motion.
using Motion = std::variant<Translation<double>, Rotation<double>, Twist<double>, Strain<double>, CustomMotion>;

// Returns u and A of the translation at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Translation<S>& motion, const Vec3<T>& d) {
  const Vec3<S> parallel = motion.axis * dot(motion.axis, motion.velocity);
  const Vec3<S> perpendicular = motion.velocity - parallel;
  const Vec3<S> half = (parallel + perpendicular * motion.gauge) * S(0.5);
  const Vec3<S> across = cross(motion.axis, perpendicular) * (S(1) - motion.gauge);
  const Vec3<T> along = Vec3<T>(motion.axis) * dot(Vec3<T>(across), d);
  return {Vec3<T>(motion.velocity), cross(Vec3<T>(half), d) + along};
}

// Returns u and A of the rotation at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Rotation<S>& motion, const Vec3<T>& d) {
  const Vec3<T> a(motion.axis);
  const T height = dot(a, d);
  const Vec3<T> d_perp = d - a * height;
  const S rest = S(1) - motion.gauge;
  const bool radial = motion.zero_gauge == RotationGauge::radial;
  const S across = motion.rate * (motion.gauge * S(0.5) + (radial ? rest : S(0)));
  const S along_rho = motion.rate * (-motion.gauge * S(0.25) - (radial ? S(0) : rest * S(0.5)));
  const S along_height = motion.rate * (radial ? rest : S(0));
  const T along = T(along_rho) * norm2(d_perp) + T(along_height) * height * height;
  return {cross(a, d) * T(motion.rate), d_perp * (T(across) * height) + a * along};
}

// Returns u and A of the twist at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Twist<S>& motion, const Vec3<T>& d) {
  const Vec3<T> a(motion.axis);
  const T height = dot(a, d);
  const Vec3<T> d_perp = d - a * height;
  const S across = motion.rate * motion.gauge * S(0.25);
  const S along = motion.rate * (-motion.gauge * S(0.25) - (S(1) - motion.gauge) * S(0.5));
  return {cross(a, d) * (T(motion.rate) * height),
          d_perp * (T(across) * height * height) + a * (T(along) * norm2(d_perp) * height)};
}

// Returns u and A of the strain at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Strain<S>& motion, const Vec3<T>& d) {
  const Vec3<T> u{dot(Vec3<T>(motion.matrix.row0), d), dot(Vec3<T>(motion.matrix.row1), d),
                  dot(Vec3<T>(motion.matrix.row2), d)};
  return {u, cross(u, d) * T(S(1) / S(3))};
}

// Returns u and A of the caller's motion at d = x - c.
template <std::floating_point T>
MotionValue<T> evaluate(const CustomMotion& motion, const Vec3<T>& d) {
  const MotionValue<double> value = (*motion.evaluate)(Vec3d(d));
  return {Vec3<T>(value.velocity), Vec3<T>(value.potential)};
}

}  // namespace knead
