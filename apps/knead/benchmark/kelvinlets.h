// What people use to pull a shape instead: the grab brush of F. de Goes and D. L. James, "Regularized Kelvinlets:
// Sculpting Brushes based on Fundamental Solutions of Elasticity", ACM Trans. Graph. 36(4), 2017, in its
// incompressible form. To measure against only: the method is patented, and no tool of ours.
#pragma once

#include <span>

#include "knead/math/vec3.h"

namespace knead::bench {

// u(r) = (eps/2) [ (1/R + eps^2/R^3) tip + r (r.tip)/R^3 ], R^2 = |r|^2 + eps^2: the paper's Eq. 6 with Poisson's ratio
// 1/2, scaled so that u(0) = tip. Free of divergence; far out it falls off as eps/|r|. T: float or double.
template <class T>
Vec3<T> kelvinlet(const Vec3<T>& r, const Vec3<T>& tip, T epsilon) {
  using std::sqrt;
  const T inverse = T(1) / sqrt(norm2(r) + epsilon * epsilon);
  const T cube = inverse * inverse * inverse;
  const T half = T(0.5) * epsilon;
  return tip * (half * (inverse + epsilon * epsilon * cube)) + r * (half * cube * dot(r, tip));
}

// The tip's path, and the size of the brush around it.
struct KelvinletBrush {
  std::span<const Vec3d> path;
  double epsilon = 0;
};

// The flow of the velocity u about the moving tip, u(0) that of the tip: what keeps volume. Classical RK4, for each
// piece of the path as many steps of equal length as are given. One thread; in float about the path's first point.
void advect_kelvinlet(const KelvinletBrush& brush, std::span<Vec3d> points, int steps_per_piece);

// So many that the tip goes by at most 0.7 epsilon in a step: errors of at most 1e-4 of `epsilon` for a path of 10 of
// it (tests/bench/kelvinlets_test.cpp).
int sufficient_steps(const KelvinletBrush& brush);

// As programs for sculpting apply it: for each piece of the path one displacement x += u(x - c), c where the piece
// begins, u(0) its whole length. One thread; in float about the path's first point.
void displace_kelvinlet(const KelvinletBrush& brush, std::span<Vec3d> points);

}  // namespace knead::bench
