// What moves points: advect() with an instruction set of this machine, or another function of its type.
#pragma once

#include <functional>
#include <span>

#include "knead/flow/advect.h"

namespace knead {

// Moves points as advect(flow, points, options) does, for example on a GPU (gpu/gpu.h). Points that no tool reaches
// keep their bits; the others agree with advect up to the tolerance, not to the bit. An empty function stands for
// advect.
using Backend = std::function<AdvectResult(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options)>;

// Returns the instruction set that advect() uses: "scalar", "avx2", "avx512", "neon" or "wasm", the one that the
// environment variable KNEAD_SIMD names, else the widest that this machine has. Results have the same bits with each.
// Throws InvalidInput if KNEAD_SIMD names an instruction set that is unknown or that the machine does not have.
const char* simd_name();

}  // namespace knead
