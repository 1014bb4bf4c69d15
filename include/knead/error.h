// The exceptions that Knead throws, the progress of long calls, and loops on several threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

namespace knead {

// Exceptions. Each message is one line: what is wrong, then what to do.

// A place in a file, to report an error there. Lines count from 1; 0 means the whole file.
struct Place {
  std::string file;
  std::size_t line = 0;
};

// Returns "FILE:LINE", or "FILE" for the whole file.
inline std::string to_string(const Place& place) {
  return place.line == 0 ? place.file : place.file + ":" + std::to_string(place.line);
}

// The caller passed an invalid value, or a file has invalid contents. The command ends with exit code 3.
class InvalidInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
  // The message begins with the place in a file.
  InvalidInput(const Place& place, const std::string& what) : std::invalid_argument(to_string(place) + ": " + what) {}
};

// The result would exceed the limits on quality: too many vertices, triangles that cross, inverted cells. The message
// says what to change. The command ends with exit code 4.
class QualityLimit : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

// A file cannot be opened, read or written.
class IoError : public std::runtime_error {
 public:
  // The operation that failed.
  enum class Operation { read, write };

  IoError(Operation operation, const std::string& file, const std::string& what)
      : std::runtime_error(file + ": " + what), operation_(operation) {}

  // Returns the operation that failed.
  Operation operation() const { return operation_; }

 private:
  Operation operation_;
};

// Long calls.

// The progress of a running call, for other threads: set `cancel` to stop it.
struct Progress {
  std::atomic<bool> cancel{false};
  std::atomic<std::uint64_t> done{0};   // points times segments, for work that moves points
  std::atomic<std::uint64_t> total{0};  // the value of `done` at the end; 0: unknown
};

// Thrown by a cancelled call whose result has no status.
class Cancelled : public std::exception {
 public:
  // Returns "cancelled".
  const char* what() const noexcept override { return "cancelled"; }
};

// Throws Cancelled if `cancel` is set. Null: never.
inline void stop_if_cancelled(const Progress* progress) {
  if (progress != nullptr && progress->cancel.load(std::memory_order_relaxed)) throw Cancelled();
}

// Splits [0, count) into chunks of at most `grain` indices and calls body(begin, end) once for each chunk, on at most
// `threads` threads (0: as many as the machine has; never more than that). The chunks depend on count and grain only,
// never on the number of threads. Returns after the last call has returned. Rethrows the first exception of a body.
void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

// Returns the number of threads that the machine runs at once: what `threads` = 0 means.
int hardware_threads();

}  // namespace knead
