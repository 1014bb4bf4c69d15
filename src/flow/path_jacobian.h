// The change of volume by the error of the integration. Internal to the library. path_jacobian.cpp also defines
// jacobians() and velocities() of flow.h.
#pragma once

#include "knead/flow.h"

namespace knead {

// Moves the points along their path lines and returns det J - 1 for each, where J is the Jacobian of the computed flow
// map. Integrates dJ/dt = grad v J along the path line, by the same method in the same steps, in double, so that the
// result shows the truncation error at options.tolerance, not rounding. Ignores `precision` and `steps`. Returns 0
// where the motion is known in closed form, and NaN where v has no derivative on the path line. Accuracy: about 1e-13 a
// step. Throws InvalidInput where advect does, and for a custom motion or region, whose derivatives are unknown;
// Cancelled.
std::vector<double> volume_drifts(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

// Moves the points along their path lines, and returns their Jacobians as jacobians() does, but also keeps the error of
// each over one segment below `jacobian_tolerance`, above 0. Throws as jacobians().
std::vector<Mat3d> move_with_jacobians(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options,
                                       double jacobian_tolerance);

}  // namespace knead
