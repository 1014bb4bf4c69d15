// The one place where Knead runs on several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace knead {

// Calls body(begin, end) for consecutive chunks of at most `grain` indices that together cover [0, count) once, on at
// most `threads` threads (0: all of the machine's; never more). Chunk boundaries depend on count and grain only, never
// on the number of threads. Returns when every call has returned; the first exception thrown by a body is rethrown.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

// The number of threads that `threads` = 0 stands for.
int hardware_threads();

}  // namespace knead
