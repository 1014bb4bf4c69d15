// Segments whose field is a grid of potentials as the numbers that the shaders read. Internal to the gpu room.
#pragma once

#include <cstddef>
#include <span>

#include "knead/gpu/packed_flow.h"

namespace knead::gpu {

// Packs segments with grids.
PackedSegments pack_grids(std::span<const Segment> segments, const AdvectOptions& options);

// Returns how many of the segments with grids, from the first on, are packed together: as far as one call of the
// shader should take, or one segment.
std::size_t count_packed_grids(std::span<const Segment> segments);

}  // namespace knead::gpu
