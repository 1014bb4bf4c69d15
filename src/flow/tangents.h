// Derivatives of path lines with respect to the numbers of a flow. Internal to the library.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "flow/varying.h"
#include "knead/flow.h"

namespace knead::detail {

// Reads the numbers of segments that a variable may change continuously, in a fixed order: begin and end, places,
// directions, rates, thresholds, the elements of point sets, the offsets of potentials under a mask, and the velocities
// of pins at fixed times.
class SegmentNumbers {
 public:
  // Segments must be like `segment`, apart from their numbers. Keeps a copy.
  explicit SegmentNumbers(const Segment& segment, const Progress* progress = nullptr);

  // Returns the numbers of a segment; nothing if it differs from the one of the constructor in more than these. Throws
  // Cancelled.
  std::optional<std::vector<double>> of(const Segment& segment) const;

  // The times at which the numbers of pins are read.
  const std::vector<double>& pin_times() const { return pin_times_; }

 private:
  Segment segment_;
  const Progress* progress_;
  std::vector<double> pin_times_;
};

// The derivatives of a segment's numbers, in the order of SegmentNumbers, with respect to up to kTangents variables;
// empty: 0.
using SegmentRates = std::array<std::span<const double>, kTangents>;

// Options of the integration.
struct TangentOptions {
  double tolerance = 0;           // of a place: a length above 0
  double relative_tolerance = 0;  // of a derivative
  int threads = 0;
  Progress* progress = nullptr;  // counts points
};

// The coefficients of a segment: the displacements of its lattice, or the coefficients of its grid and then those at
// its end; none of another segment. Growth is not among them.
std::size_t count_coefficients(const Segment& segment);

// Moves points through a segment together with their derivatives with respect to one variable: dT/dt = grad v T +
// dv/dvariable. `rates`: of the segment's numbers; empty: 0. `tangents`: as many as points. The bits of a result depend
// on its point alone. Throws InvalidInput for a custom motion or region, and if a path line needs more than kStepLimit
// steps; Cancelled.
void advect_tangents(const Segment& segment, std::span<const double> rates, std::span<Vec3d> points,
                     std::span<Vec3d> tangents, const TangentOptions& options);

// The same for a segment with coefficients, which change at these rates.
void advect_tangents_by_coefficients(const Segment& segment, std::span<const Vec3d> rates, std::span<Vec3d> points,
                                     std::span<Vec3d> tangents, const TangentOptions& options);

// Backwards.

// The gradient of a function with respect to the points at the beginning of a flow, and to the variables or the
// coefficients of each segment, three numbers a coefficient.
struct FlowGradient {
  std::vector<Vec3d> points;
  std::vector<std::vector<double>> variables;
};

// Which numbers of a segment are wanted, in the order of SegmentNumbers; empty: none.
using WantedNumbers = std::vector<bool>;

// Carries the gradient with respect to the moved points back through a valid flow. `rates`: of each segment the
// derivatives of its numbers, in the order of SegmentNumbers, with respect to each of its variables. Moves the points
// with the Jacobian of each segment, and with the derivatives by its variables, in packs where kernels do. A point
// costs a segment 12 numbers and 3 for each variable, of at most 2^20 points and segments at a time, for each thread.
// Sums have a fixed order, so the bits do not depend on the number of threads. Throws as advect_tangents.
FlowGradient carry_back(const Flow& flow, const std::vector<std::vector<std::span<const double>>>& rates,
                        std::span<const Vec3d> points, std::span<const Vec3d> gradient, const TangentOptions& options);

// The same, with the coefficients of each segment in the place of variables.
FlowGradient carry_back_to_coefficients(const Flow& flow, std::span<const Vec3d> points,
                                        std::span<const Vec3d> gradient, const TangentOptions& options);

}  // namespace knead::detail
