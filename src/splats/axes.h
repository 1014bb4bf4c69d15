// The axes of splats. Internal to the library.
#pragma once

#include <array>

#include "knead/vec.h"

namespace knead::detail {

// Rotates the columns of m, in pairs, until they are orthogonal to each other: M V = U S for M given. Turns by
// at most 45 degrees each time, so that columns stay near those that they were.
void orthogonalise(std::array<Vec3d, 3>& m);

}  // namespace knead::detail
