// Deforms points by the lines of a session, independently of the library: strokes are read straight from the JSON,
// fields are formed as in the paper (v = grad p x grad q from e, f and b), and path lines are integrated by
// Boost.Odeint's Runge-Kutta-Fehlberg 7(8) at a tolerance of 1e-12. Slow, and written to be compared with.
#pragma once

#include <string>
#include <vector>

#include "knead/math/vec3.h"

namespace knead::oracle {

// `size` is the length that tolerances are relative to. Knows implicit, paint with samples, points, rotate, stretch,
// twist and bend.
std::vector<Vec3d> deform(const std::vector<std::string>& stroke_lines, std::vector<Vec3d> points, double size);

}  // namespace knead::oracle
