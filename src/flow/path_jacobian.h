// How exactly the integration of path lines keeps volume. Internal to the library. path_jacobian.cpp also has
// jacobians() and velocities() of flow.h.
#pragma once

#include "knead/flow.h"

namespace knead {

// Moves the points along their path lines and returns det J - 1 for each, where J is the Jacobian of the computed flow
// map there. Integrates dJ/dt = grad v J along the path line, in the same steps and by the same method. Computes in
// double, so that the result shows the truncation of the method at options.tolerance, not rounding. `precision` and
// `steps` are not used. Returns 0 where the motion is known in closed form, and not a number where v has no derivative
// on the path line. Accuracy: about 1e-13 a step. Throws InvalidInput where advect does, and for a motion or region of
// the caller's own, whose derivatives are not known; Cancelled.
std::vector<double> volume_drifts(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

}  // namespace knead
