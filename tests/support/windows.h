// For tests on Windows, included before all else: functions of POSIX that it lacks.
#pragma once

#include <cstdlib>
#include <string>

inline int setenv(const char* name, const char* value, int /*overwrite*/) {
  return ::_putenv((std::string(name) + "=" + value).c_str());
}
inline int unsetenv(const char* name) { return setenv(name, "", 1); }
