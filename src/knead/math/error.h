// The two exceptions that Knead throws. Each message is one line: what is wrong, then what to do.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace knead {

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
  InvalidInput(const Place& place, const std::string& what) : std::invalid_argument(to_string(place) + ": " + what) {}
};

// A file cannot be opened, read or written.
class IoError : public std::runtime_error {
 public:
  // What was tried with the file.
  enum class Operation { read, write };

  IoError(Operation operation, const std::string& file, const std::string& what)
      : std::runtime_error(file + ": " + what), operation_(operation) {}

  // Returns what was tried with the file.
  Operation operation() const { return operation_; }

 private:
  Operation operation_;
};

}  // namespace knead
