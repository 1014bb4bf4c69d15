// Deforms points by the lines of a session, independently of the library: strokes are read straight from the JSON,
// fields are formed from the paper's e, f and b, and path lines are integrated by Boost.Odeint's Dormand-Prince method
// at 1e-14 a step. Slow, and written to be compared with. (Odeint's Fehlberg 7(8) is no reference: its error estimate
// misses what happens within a step, and it errs by 1e-8 where a path line crosses the planes through a capsule's
// ends.)
#pragma once

#include <string>
#include <vector>

#include "knead/vec.h"

namespace knead::oracle {

// `size` is the length that tolerances are relative to. Knows implicit, paint with samples, points, handles with
// points, rotate, stretch, twist, bend and pins.
std::vector<Vec3d> deform(const std::vector<std::string>& stroke_lines, std::vector<Vec3d> points, double size);

}  // namespace knead::oracle
