// The step that raises the least of several values. Internal to the remesh room.
#pragma once

#include <span>

#include "knead/math/vec3.h"

namespace knead::remesh_detail {

// Returns the step d for which the least of value + gradient . d, less |d|^2 / (2 reach), is greatest. There is at
// least one value, and as many gradients. A step where no value can rise is 0.
//
// Method: the dual problem looks for the weights of the gradients whose sum is the step. At most four are above 0,
// which are found by an active set: P. Wolfe, "Finding the nearest point in a polytope", Mathematical Programming 11,
// 1976.
Vec3d best_step(std::span<const double> values, std::span<const Vec3d> gradients, double reach);

}  // namespace knead::remesh_detail
