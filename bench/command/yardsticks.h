// The yardsticks of `knead bench`: the limits of the machine, the operations of the kernels, the paper's method in its
// plain form, and another brush.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::bench {

// Returns multiply-adds a second times two, in units of 1e9, of `threads` threads at once, with the widest vectors of
// this machine (AVX-512, AVX2, else plain code). Takes about 0.2 s.
double fma_gflops(Precision precision, int threads);

// Returns the best rate at which one thread copies memory far larger than its caches, in units of 1e9 bytes read and
// written a second.
double copy_gigabytes_per_second();

// Returns the number of additions, subtractions, multiplications, divisions and square roots with which the kernels
// move the points through the flow, a multiply-add being two: in evaluating fields, stepping and estimating errors.
// Runs the kernels with numbers that count. Comparisons, selections, conversions, the classification of points and
// closed forms do not count. 0 if a segment has no pack kernel.
std::uint64_t operations_of(const Flow& flow, std::span<const Vec3d> points, const AdvectOptions& options);

struct ReferenceResult {
  std::uint64_t accepted_steps = 0;
  std::uint64_t evaluations = 0;
};

// Moves the points in place by the paper's method in its plain form: structures of doubles, one path line after the
// other on one core, v = grad p x grad q, RK4 with step doubling, and no test for points that no tool reaches.
// `tolerance` is the length by which two half steps may differ from a whole one, over 15.
// No step lets the tool go further than a fifth of the intermediate region's width, so that it is not missed. For
// whole swept segments of one field, without a limit cylinder.
ReferenceResult advect_reference(const Flow& flow, std::span<Vec3d> points, double tolerance);

// The grab brush of F. de Goes and D. L. James, "Regularized Kelvinlets: Sculpting Brushes based on Fundamental
// Solutions of Elasticity", ACM Trans. Graph. 36(4), 2017, in its incompressible form. For the benchmark only: the
// method is patented, and Knead has no tool that uses it. u(r) = (eps/2) [ (1/R + eps^2/R^3) tip + r (r.tip)/R^3 ], R^2
// = |r|^2 + eps^2: the paper's Eq. 6 with Poisson's ratio 1/2, scaled so that u(0) = tip. Free of divergence; far out
// it falls off as eps/|r|. T: float or double.
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

// Moves the points by the flow of the velocity u about the moving tip, with u(0) the velocity of the tip; this keeps
// volume. Classical RK4 with `steps_per_piece` equal steps. One thread; in float about its first point.
void advect_kelvinlet(const KelvinletBrush& brush, std::span<Vec3d> points, int steps_per_piece);

// Returns the number of steps with which the tip moves by at most 0.7 epsilon in a step. The error is then at most 1e-4
// of epsilon for a path of 10 epsilon (tests/bench/kelvinlets_test.cpp).
int sufficient_steps(const KelvinletBrush& brush);

// Moves the points as sculpting programs do: for each piece of the path one displacement x += u(x - c), c where the
// piece begins, u(0) its whole length. One thread; in float about the path's first point.
void displace_kelvinlet(const KelvinletBrush& brush, std::span<Vec3d> points);

}  // namespace knead::bench
