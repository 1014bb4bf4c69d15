// Exact orientation tests of points, and exact tests of triangles.
#pragma once

#include <array>

#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

// Coordinates must be 0 or from 2^-250 to 2^250 (about 1e-75 to 1e75) in magnitude: then no intermediate result
// overflows or underflows. Scale other coordinates by a power of two first. The sign is exact for every such input;
// exchanging two points changes it.
//
// Method: the determinant in double precision with a bound on its error; if the bound does not decide, expansion
// arithmetic. J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates",
// Discrete & Computational Geometry 18, 1997. Cost: about 5 ns if the bound decides, else about 1 us.

// Returns the sign of (b - a) x (c - a) . (d - a): 1 if a, b, c appear counter-clockwise from d, -1 if clockwise, 0 if
// the four points are coplanar.
int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

// Returns the sign of component `axis` (0, 1 or 2) of (b - a) x (c - a): 1 if a, b, c appear counter-clockwise from the
// positive end of that axis, -1 if clockwise, 0 if they appear collinear.
int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis);

// Returns the coordinate axis in which a normal is longest.
int widest_axis(const Vec3d& normal);

// The positions of the corners of a triangle, in the range that orient3d() requires.
using Corners = std::array<Vec3d, 3>;

// Returns true if the corners lie on one line, or at one point.
bool are_collinear(const Corners& corners);

// Returns true if two triangles meet in more than their shared vertices and edges, as self_intersections() defines it.
// Neither may be collinear.
bool meet_beyond_shared(const Triangle& t, const Corners& t_corners, const Triangle& u, const Corners& u_corners);

}  // namespace knead
