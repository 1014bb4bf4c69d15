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

// What a point moves less than this part of the width of a field's transition, it does not move at all.
inline constexpr double kLeastMotion = 1e-14;

// Segments of one kind, one after the other.
struct PackedSegments {
  int count = 0;
  std::vector<double> numbers;      // n[], to be rounded to float unless the kind is in double
  std::vector<double> places;       // e[]
  std::vector<std::int32_t> table;  // table[]
};

// Packs segments of one kind, as many as pack_length returns. Returns the packs of one shader's calls: several where
// the first segment has pins, none where options.progress->cancel was set. Throws InvalidInput where the equations of
// pins cannot be solved.
std::vector<PackedSegments> pack(std::span<const Segment> segments, const AdvectOptions& options);

// Returns how many of the segments, from the first on, are packed together: those of the first's kind, as far as one
// call of the shader should take, or one segment with pins.
std::size_t pack_length(std::span<const Segment> segments, const AdvectOptions& options);

}  // namespace knead::gpu
