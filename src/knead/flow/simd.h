// Which instruction set the inner loops use.
#pragma once

namespace knead {

// "scalar", "avx2", "avx512" or "neon": the widest that this machine has, or what the environment variable KNEAD_SIMD
// names. Results are the same bits with each. Throws InvalidInput where KNEAD_SIMD names one that there is not, or that
// the machine does not have.
const char* simd_name();

}  // namespace knead
