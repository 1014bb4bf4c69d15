// Inverses and polar factors of 3x3 matrices. Internal to the library.
#pragma once

#include "knead/vec.h"

namespace knead {

// Returns the inverse of a matrix whose determinant is not 0.
Mat3d inverse(const Mat3d& m);

inline Mat3d transposed(const Mat3d& m) { return {m.column(0), m.column(1), m.column(2)}; }

// Returns the rotation R of m = R U, where U is symmetric: the rotation nearest to m, whose determinant is above 0.
// Method: Newton's iteration (Higham 1986).
Mat3d nearest_rotation(const Mat3d& m);

// Returns the logarithm of V of m = V R, where V is symmetric, to third order: the strain of a deformation, in the
// directions after it. The determinant of m must be above 0.
Mat3d log_strain(const Mat3d& m);

}  // namespace knead
