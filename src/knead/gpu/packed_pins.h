// Segments with pins as the numbers that the shaders read. Internal to the gpu room.
#pragma once

#include <vector>

#include "knead/gpu/packed_flow.h"

namespace knead::gpu {

// Solves the equations of a segment's pins and packs the pieces of its time, in the order in which path lines pass
// them. Returns a pack for each call of a shader; none where options.progress->cancel is set. Throws InvalidInput where
// the equations cannot be solved.
std::vector<PackedSegments> pack_pins(const Segment& segment, const AdvectOptions& options);

}  // namespace knead::gpu
