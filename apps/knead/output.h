// What the command measures and writes: time, results to standard output, messages to standard error, files checked
// before long work, progress; and what ends it early.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "knead/flow.h"

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

// Returns the text with the letters A to Z in lower case.
std::string lower_case(std::string text);

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

// --- a progress bar on a terminal

// While it lives: a bar on standard error, drawn by a thread that watches progress.done, from 0.3 seconds on; erased
// at the end. No bar where `wanted` is false, standard error is no terminal, or the terminal is dumb. The bar has no
// colours and needs no escape codes. Behind it stands how many of the frames are done, if there are any.
class ProgressBar {
 public:
  // total: of progress.done; 0: progress.total. `unit`: what the frames are.
  ProgressBar(const Progress& progress, std::uint64_t total, bool wanted, int frames = 0, const char* unit = "frames");

  void count_frame() { ++frames_done_; }

 private:
  void tick(const std::stop_token& stop, const Progress& progress, std::uint64_t total, int frames,
            const char* unit) const;

  std::atomic<int> frames_done_{0};
  std::jthread ticker_;
};

// --- Ctrl-C and similar signals: they end the work and leave no file half-written

// From now on SIGINT, SIGTERM and SIGHUP (unless ignored) remove unfinished files and end the program with
// kInterrupted.
void handle_interruptions();

// Call before the last file is written: an interruption that comes when it is in place, or when all of `files` are that
// take their places together, ends the program with kDone.
// more_to_say: printing or a report follows that was asked for, so that the first such interruption is ignored.
void end_after_last_output(bool more_to_say, std::size_t files = 1);

// While it lives, the first interruption sets progress.cancel instead; a second one ends the program. One at a time.
class CancelOnInterruption {
 public:
  explicit CancelOnInterruption(Progress& progress);
  CancelOnInterruption(const CancelOnInterruption&) = delete;
  CancelOnInterruption& operator=(const CancelOnInterruption&) = delete;
  ~CancelOnInterruption();

 private:
  Progress& progress_;
};

}  // namespace knead::command
