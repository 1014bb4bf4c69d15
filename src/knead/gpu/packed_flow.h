// Segments as the numbers that the shaders read. Internal to the gpu room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/gpu/glsl.h"

namespace knead::gpu {

// Throws InvalidInput, saying which, where a field is one of the caller's own functions, of which a shader knows
// nothing.
ShaderKind kind_of(const Segment& segment, const AdvectOptions& options);

// Segments of one kind, one after the other.
struct PackedSegments {
  int count = 0;
  std::vector<double> numbers;      // n[], to be rounded to float unless the kind is in double
  std::vector<double> places;       // e[]
  std::vector<std::int32_t> table;  // table[]
};

PackedSegments pack(std::span<const Segment> segments, const AdvectOptions& options);

// How many of the segments, from the first on, go into one pack: those of the first's kind, as far as one call of the
// shader should take.
std::size_t pack_length(std::span<const Segment> segments, const AdvectOptions& options);

}  // namespace knead::gpu
