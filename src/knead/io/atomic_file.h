// Files that are either whole or not there.
#pragma once

#include <filesystem>
#include <string_view>

namespace knead {

// Replaces the contents of the file at `path`, or creates it: written under a temporary name in the same folder,
// synced, renamed. A link is followed, and the permissions of an existing file are kept. On failure, and if the program
// dies, the old file stays whole. What is no regular file (a pipe, a terminal, /dev/null) is written directly. Throws
// IoError(write).
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

// Removes the temporary files of calls of write_file_atomically that are under way. Safe to call from a signal handler
// of a program that then ends.
void discard_unfinished_files() noexcept;

}  // namespace knead
