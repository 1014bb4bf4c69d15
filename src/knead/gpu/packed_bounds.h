// Where fields can be felt, as the numbers that the shaders read. Internal to the gpu room.
#pragma once

#include <cstddef>
#include <vector>

#include "knead/flow/segment.h"
#include "knead/math/mat3.h"

namespace knead::gpu {

// Writes the three numbers of v, or the nine of m by rows, from `at` on.
void put(std::vector<double>& to, std::size_t at, const Vec3d& v);
void put(std::vector<double>& to, std::size_t at, const Mat3d& m);

// Writes layout::kFieldBounds numbers from `at` on: where the support of a field of the segment lies at all times from
// its begin to its end.
void put_bounds(std::vector<double>& places, std::size_t at, const Field& field, const Segment& segment);

}  // namespace knead::gpu
