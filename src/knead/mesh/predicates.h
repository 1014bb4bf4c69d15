// Exact signs of orientations.
#pragma once

#include "knead/math/vec3.h"

namespace knead {

// Coordinates may be 0, or from 2^-250 to 2^250 (about 1e-75 to 1e75) in magnitude: within that no intermediate result
// overflows or loses bits below the smallest double. Scale others by a power of two first. The sign is exact for every
// such input, and so antisymmetric under the exchange of two points.
//
// Method: the determinant in doubles with a bound on its error, and where that does not decide, in expansion
// arithmetic. J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates",
// Discrete & Computational Geometry 18, 1997. Some 5 ns where the bound decides, a microsecond where not.

// 1 if d lies on that side of the plane through a, b, c from which they appear counter-clockwise, -1 if on the other,
// 0 if the four are coplanar: the sign of (b - a) x (c - a) . (d - a).
int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

// 1 if a, b, c turn counter-clockwise, -1 if clockwise, 0 if they are collinear, seen along coordinate `axis` (0, 1
// or 2) from its positive end: the sign of that component of (b - a) x (c - a).
int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis);

}  // namespace knead
