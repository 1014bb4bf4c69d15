// How exactly the integration of path lines keeps volume. Internal to the library. path_jacobian.cpp also has
// jacobians() and velocities() of advect.h.
#pragma once

#include "knead/flow/advect.h"

namespace knead {

// Moves x along its path line and returns det J - 1, where J is the Jacobian at x of the computed flow map. Integrates
// dJ/dt = grad v J along the path line, in the same steps and by the same method. Computes in double, so that the
// result shows the truncation of the method at options.tolerance, not rounding; of the other options only `integrator`
// is used. Returns 0 where the motion is known in closed form, and not a number where v has no derivative on the path
// line. Accuracy: about 1e-13 a step. Throws InvalidInput where advect does, and for a motion or region of the caller's
// own, whose derivatives are not known.
double volume_drift(const Flow& flow, const AdvectOptions& options, Vec3d& x);

}  // namespace knead
