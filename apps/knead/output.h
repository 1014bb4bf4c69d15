// What the command measures and writes: time, results to standard output, messages to standard error, files checked
// before long work.
#pragma once

#include <chrono>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace knead::command {

// Measures the wall-clock time since it was made.
class Clock {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Writes to standard output at once. Throws IoError(write).
void print(std::string_view text);

// Prints one line on standard error: "knead: " and the message, with control characters (of file names, say) escaped.
void print_message(std::string_view message) noexcept;

// Returns "1 stroke", "2 strokes".
std::string counted(std::size_t count, std::string_view noun);

// Prints each note as a line: "knead: note: ...".
void print_notes(std::span<const std::string> notes);

// Returns the extension ("ply") that the path ends in, in upper or lower case. Throws UsageError if it is none of
// these.
std::string require_extension(const std::filesystem::path& path, std::span<const std::string_view> extensions);

// Returns whether the path's extension is that of a shape.
bool is_shape_file(const std::filesystem::path& path);

// Does what require_extension does, for the extensions of shapes.
void require_shape_extension(const std::filesystem::path& path);

// Throws IoError(write) if no file can be written there. Creates nothing.
void require_writable(const std::filesystem::path& path);

// Throws UsageError if two paths name the same file, which need not exist.
void require_different(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace knead::command
