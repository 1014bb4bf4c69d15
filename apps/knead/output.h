// What the command writes: results to standard output, messages to standard error, files checked before long work.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace knead::command {

// Writes to standard output at once. Throws IoError(write).
void print(std::string_view text);

// One line on standard error: "knead: " and the message, with control characters (of file names, say) escaped.
void print_message(std::string_view message) noexcept;

// "1 stroke", "2 strokes".
std::string counted(std::size_t count, std::string_view noun);

// Remarks, a line each: "knead: note: ...".
void print_notes(std::span<const std::string> notes);

// Which of the extensions ("ply") the path ends in, in upper or lower case. Throws UsageError where it is none.
std::string require_extension(const std::filesystem::path& path, std::span<const std::string_view> extensions);

// The same for a shape's file.
void require_shape_extension(const std::filesystem::path& path);

// Whether a file could be written there, found out without leaving a trace. Throws IoError(write) where it could not.
void require_writable(const std::filesystem::path& path);

// Throws UsageError where two paths name one file, existing or not.
void require_different(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace knead::command
