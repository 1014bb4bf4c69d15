// The instruction set that advect() uses.
#pragma once

namespace knead {

// Returns "scalar", "avx2", "avx512", "neon" or "wasm": the one that the environment variable KNEAD_SIMD names, else
// the widest that this machine has. Results have the same bits with each. Throws InvalidInput if KNEAD_SIMD names an
// instruction set that is unknown or that the machine does not have.
const char* simd_name();

}  // namespace knead
