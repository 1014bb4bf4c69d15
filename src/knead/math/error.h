// The two kinds of failure that Knead reports by exception. Every message is one line: what is wrong; what to do.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace knead {

// Where in a file something is wrong. line counts from 1; 0: the file as a whole.
struct Place {
  std::string file;
  std::size_t line = 0;
};

inline std::string to_string(const Place& place) {
  return place.line == 0 ? place.file : place.file + ":" + std::to_string(place.line);
}

// The caller's fault: values or file contents that mean nothing (exit code 3 of the command).
class InvalidInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
  InvalidInput(const Place& place, const std::string& what) : std::invalid_argument(to_string(place) + ": " + what) {}
};

// The outside world: a file that cannot be opened, read or written.
class IoError : public std::runtime_error {
 public:
  enum class Operation { read, write };

  IoError(Operation operation, const std::string& file, const std::string& what)
      : std::runtime_error(file + ": " + what), operation_(operation) {}

  Operation operation() const { return operation_; }

 private:
  Operation operation_;
};

}  // namespace knead
