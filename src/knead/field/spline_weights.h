// The cubic B-spline, as masks and potential grids are made of. Internal to the library.
#pragma once

#include "knead/math/scalar.h"

namespace knead::detail {

// Six times the cubic B-spline's weights of the four nodes around a place, and their derivatives.
template <class T>
struct SplineWeights {
  T value[4];
  T slope[4];
};

template <class T>
[[gnu::always_inline]] inline SplineWeights<T> spline_weights(const T& u) {
  const T q = T(1) - u;
  const T u2 = u * u;
  const T q2 = q * q;
  SplineWeights<T> w;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
  w.value[0] = q2 * q;
  w.value[1] = mul_add(u2, mul_add(T(3), u, T(-6)), T(4));
  w.value[2] = mul_add(q2, mul_add(T(3), q, T(-6)), T(4));
  w.value[3] = u2 * u;
  w.slope[0] = T(-3) * q2;
  w.slope[1] = u * mul_add(T(9), u, T(-12));
  w.slope[2] = q * mul_add(T(-9), q, T(12));
  w.slope[3] = T(3) * u2;
  return w;
}

// Six times the second derivatives of the weights.
template <class T>
[[gnu::always_inline]] inline void spline_curvatures(const T& u, T (&curvature)[4]) {
  const T q = T(1) - u;
  curvature[0] = T(6) * q;
  curvature[1] = mul_add(T(18), u, T(-12));
  curvature[2] = mul_add(T(18), q, T(-12));
  curvature[3] = T(6) * u;
}

}  // namespace knead::detail
