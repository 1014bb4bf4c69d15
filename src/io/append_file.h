// A locked file that grows by whole pieces of text, and keeps them in memory while the disk refuses them.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace knead::detail {

class AppendFile {
 public:
  // Opens the file, creates it if it is missing, and takes its lock (flock). Throws IoError(write), and InvalidInput if
  // another process holds the lock.
  explicit AppendFile(const std::filesystem::path& path);
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;
  // Tries once more to write the waiting text, waits for a sync that is running, and releases the lock.
  ~AppendFile();

  // Truncates the file to this length in bytes. Call it before anything is appended. Throws IoError(write).
  void cut(std::size_t length);

  // Appends the waiting text and this text by one call of write(2). On failure the file is truncated to whole pieces
  // again, the text waits in memory, and a call at least a second later tries again.
  void append(std::string_view text);

  // Starts to flush the file to the disk on a thread of its own; returns at once.
  void sync();

  // Returns the latest failure if no write has succeeded since, e.g. "No space left on device".
  std::optional<std::string> trouble() const;

 private:
  class Syncer;

  void write_waiting();
  void fail(int error);

  std::string path_;  // for messages
  int file_ = -1;
  std::size_t length_ = 0;  // of whole pieces in the file
  bool torn_ = false;       // the file may be longer than that
  std::string waiting_;
  int error_ = 0;
  std::chrono::steady_clock::time_point next_attempt_{};
  std::unique_ptr<Syncer> syncer_;
};

}  // namespace knead::detail
