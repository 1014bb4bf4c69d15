// Writes files as a whole: after a failure the old file is still there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string_view>

namespace knead {

// Replaces the contents of the file at `path`, or creates it. Writes a temporary file in the same folder, syncs it to
// disk and renames it, so the old file stays intact if this fails or the program dies. Follows a link, also one whose
// target does not exist yet, and keeps the permissions of an existing file. Writes directly to a path that is not a
// regular file (a pipe, a terminal, /dev/null). Throws IoError(write).
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

// A file that is written piece by piece, with the promises of write_file_atomically.
class AtomicFile {
 public:
  // Creates the temporary file. Throws IoError(write).
  explicit AtomicFile(const std::filesystem::path& path);

  // Creates the temporary file of a part that belongs to another file in the same folder, which is put in place last.
  // If the program is killed, both are known as abandoned together. Throws IoError(write).
  AtomicFile(const std::filesystem::path& path, const AtomicFile& whole);

  // Without finish() before, the old file stays.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) noexcept;

  // Appends the bytes. Throws IoError(write).
  void write(std::string_view bytes);

  // Syncs and closes the temporary file: nothing can be written after it. Throws IoError(write).
  void close();

  // Closes the file, if that is not done, and puts it in place. Throws IoError(write).
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// Removes the temporary files of AtomicFile, and of calls of write_file_atomically that have not returned yet. A signal
// handler may call this before it ends the program.
void discard_unfinished_files() noexcept;

// Removes the temporary files in a folder that killed programs have left behind. Those of running programs stay.
void discard_abandoned_files(const std::filesystem::path& folder) noexcept;

// Returns how many files were put in place so far; one that is renamed at this moment may count
// twice. A signal handler may call this: a larger number than before means that a file is in place.
std::size_t count_files_in_place() noexcept;

// Returns the file that a path stands for, whether it exists or not: links at its end are followed.
std::filesystem::path followed_link(const std::filesystem::path& path);

}  // namespace knead
