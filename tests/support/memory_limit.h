// For tests: limits the memory of the process.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace knead::test {

// Allows the process its memory of now and `more` bytes, until lift_memory_limit().
inline void limit_memory(rlim_t more) {
  std::ifstream file("/proc/self/statm");
  rlim_t pages = 0;
  file >> pages;
  rlimit limit{};
  ::getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + more;
  ::setrlimit(RLIMIT_AS, &limit);
}

inline void lift_memory_limit() {
  rlimit limit{};
  ::getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_AS, &limit);
}

}  // namespace knead::test
