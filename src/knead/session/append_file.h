// A locked file that grows by whole pieces of text, and goes on in memory while the disk refuses them.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace knead::session_detail {

class AppendFile {
 public:
  // Opens the file, creates it where it is missing, and takes its lock (flock). Throws IoError(write); InvalidInput
  // where another process holds the lock.
  explicit AppendFile(const std::filesystem::path& path);
  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&& other) noexcept;
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;
  // Tries once more to write what waits, waits for a sync under way, and lets the lock go.
  ~AppendFile();

  // Cuts off what stands after this many bytes. Throws IoError(write). To be called before anything is appended.
  void cut(std::size_t length);

  // Appends the text by one call of write(2), together with what waits. On failure what was written of it is cut off
  // again, all of it waits in memory, and the next attempt is made by a call at least a second later.
  void append(std::string_view text);

  // Lets a thread of its own bring what is written to the disk; returns at once.
  void sync();

  // What the latest failure was and has not been made good since, e.g. "No space left on device".
  std::optional<std::string> trouble() const;

 private:
  class Syncer;

  void write_waiting();
  void fail(int error);
  void finish() noexcept;

  std::string path_;  // for messages
  int file_ = -1;
  std::size_t length_ = 0;  // of whole pieces in the file
  bool torn_ = false;       // the file may be longer than that
  std::string waiting_;
  int error_ = 0;
  std::chrono::steady_clock::time_point next_attempt_{};
  std::unique_ptr<Syncer> syncer_;
};

}  // namespace knead::session_detail
