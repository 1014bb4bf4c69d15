// How far the integration of path lines is from keeping volume.
#pragma once

#include "knead/flow/advect.h"

namespace knead {

// det J - 1 for the Jacobian J, at x, of the map that the integration is: dJ/dt = grad v J is taken along the path line
// in the same steps, by the same method. In double, so that what is seen is the truncation of the method at
// options.tolerance (of the other options only `integrator` is looked at) and nothing of rounding; 0 where the motion
// is known in closed form. x is moved along. Accuracy: about 1e-13 a step. Not a number where v has no derivative on
// the way. Throws InvalidInput as advect, and for a caller's own motion or region, whose derivatives are not known.
double volume_drift(const Flow& flow, const AdvectOptions& options, Vec3d& x);

}  // namespace knead
