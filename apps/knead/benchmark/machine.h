// Measures the limits of the machine: multiply-adds and copied bytes per second.
#pragma once

#include "knead/flow.h"

namespace knead::bench {

// Returns multiply-adds a second times two, in units of 1e9, of `threads` threads at once, with the widest vectors of
// this machine (AVX-512, AVX2, else plain code). Takes about 0.2 s.
double fma_gflops(Precision precision, int threads);

// Returns the best rate at which one thread copies memory far larger than its caches, in units of 1e9 bytes read and
// written a second.
double copy_gigabytes_per_second();

}  // namespace knead::bench
