// Derivatives of path lines backwards: the gradient of a function of the moved points, carried back to the points and
// to the numbers of the flow. Internal to the library.
#pragma once

#include <span>
#include <vector>

#include "flow/tangents.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// The gradient of a function with respect to the points at the beginning of a flow, and to the numbers of each segment,
// in the order of SegmentNumbers; none of a segment of which none is wanted.
struct FlowGradient {
  std::vector<Vec3d> points;
  std::vector<std::vector<double>> numbers;
};

// Which numbers of a segment are wanted, in the order of SegmentNumbers; empty: none.
using WantedNumbers = std::vector<bool>;

// Carries the gradient with respect to the moved points back through a valid flow. `wanted`: of each segment. Moves
// each point as advect_tangents would with its Jacobian, then goes back through the steps: one evaluation for each of
// their stages, however many numbers are wanted. Holds the steps of one point for each thread. Sums have a fixed order,
// so the bits do not depend on the number of threads. Throws as advect_tangents.
FlowGradient carry_back(const Flow& flow, const std::vector<WantedNumbers>& wanted, std::span<const Vec3d> points,
                        std::span<const Vec3d> gradient, const TangentOptions& options);

}  // namespace knead::detail
