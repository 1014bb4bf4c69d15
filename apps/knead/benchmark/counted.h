// Counts the arithmetic operations of the kernels.
#pragma once

#include <cstdint>
#include <span>

#include "knead/flow.h"

namespace knead::bench {

// Additions, subtractions, multiplications, divisions and square roots, a multiply-add being two, that the kernels do
// to move the points through the flow: evaluating fields, stepping and estimating errors. Found by running them with
// numbers that count. Comparisons, selections and conversions do not count, nor what is done in
// classifying points and in closed form. 0 where a segment's fields have no kernel.
std::uint64_t operations_of(const Flow& flow, std::span<const Vec3d> points, const AdvectOptions& options);

}  // namespace knead::bench
