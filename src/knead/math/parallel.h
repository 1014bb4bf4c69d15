// Runs loops on several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace knead {

// Splits [0, count) into chunks of at most `grain` indices and calls body(begin, end) once for each chunk, on at most
// `threads` threads (0: as many as the machine has; never more than that). The chunks depend on count and grain only,
// never on the number of threads. Returns after the last call has returned. Rethrows the first exception of a body.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

// Returns the number of threads that the machine runs at once: what `threads` = 0 means.
int hardware_threads();

}  // namespace knead
