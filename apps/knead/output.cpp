// Writes the results and messages of the command, and checks output files before the work begins.
#include "output.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

#include "command.h"
#include "knead/error.h"
#include "knead/io.h"
#include "program.h"

namespace knead::command {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw IoError(IoError::Operation::write, path.string(), what);
}

std::string reason(int error) { return std::generic_category().message(error); }

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    } else {
      result += c;
    }
  }
  return result;
}

void require_writable_folder(const fs::path& path, const fs::path& folder) {
  const int error = error_of_making_files_in(folder);
  if (error == 0) return;
  if (error == ENOENT) fail(path, fmt::format("the folder {} does not exist; create it first", folder.string()));
  if (error == ENOTDIR) fail(path, fmt::format("{} is no folder; write somewhere else", folder.string()));
  fail(path, fmt::format("its folder cannot be written to ({}); check its permissions", reason(error)));
}

// Without the point, in lower case.
std::string extension_of(const fs::path& path) {
  const std::string extension = lower_case(shape_suffix(path));
  return extension.empty() ? extension : extension.substr(1);
}

using namespace std::chrono_literals;

constexpr int kWidth = 40;

std::string bar_line(std::uint64_t done, std::uint64_t total) {
  const double part = total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const std::string marks(static_cast<std::size_t>(part * kWidth), '#');
  return fmt::format("\r[{:<{}}] {:3.0f}%", marks, kWidth, 100 * part);
}

void show(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

// The progress that the next interruption cancels. A signal handler can only use a global variable.
std::atomic<Progress*> cancellable = nullptr;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
// Set before the last file is written.
std::atomic<bool> awaits_last_output = false;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<bool> has_more_to_say = false;     // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<std::size_t> files_at_end = 0;     // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
static_assert(std::atomic<Progress*>::is_always_lock_free);
static_assert(std::atomic<bool>::is_always_lock_free);

void on_interruption(int /*signal*/) {
  if (Progress* progress = cancellable.exchange(nullptr)) {
    progress->cancel = true;
    return;
  }
  if (awaits_last_output && count_files_in_place() >= files_at_end) {
    if (has_more_to_say.exchange(false)) return;
    end_process(kDone);
  }
  discard_unfinished_files();
  write_error_output("knead: interrupted\n");
  end_process(kInterrupted);
}

}  // namespace

void print(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    if (errno == EPIPE) throw ClosedPipe{};
    fail("standard output", fmt::format("cannot be written ({}); check where it goes", reason(errno)));
  }
}

void print_message(std::string_view message) noexcept {
  try {
    const std::string line = "knead: " + escaped(message) + "\n";
    std::fwrite(line.data(), 1, line.size(), stderr);
  } catch (const std::exception&) {
    std::fputs("knead: out of memory; try a smaller shape\n", stderr);
  }
}

std::string lower_case(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
  return text;
}

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

void print_notes(std::span<const std::string> notes) {
  constexpr std::string_view kStroke = "--stroke: ";  // the place of a stroke that no file has
  for (const std::string& note : notes) {
    print_message("note: " + note.substr(note.starts_with(kStroke) ? kStroke.size() : 0));
  }
}

std::string require_extension(const fs::path& path, std::span<const std::string_view> extensions) {
  std::string extension = extension_of(path);
  std::string supported;
  for (const std::string_view each : extensions) {
    if (extension == each) return extension;
    supported += fmt::format("{}.{}", supported.empty() ? "" : " or ", each);
  }
  throw UsageError(
      fmt::format("{}: cannot write this kind of file; name one that ends in {}", path.string(), supported));
}

bool is_shape_file(const fs::path& path) {
  constexpr std::string_view gzip = ".gz";
  const auto extensions = shape_extensions();
  std::string extension = extension_of(path);
  if (extension.ends_with(gzip)) extension.resize(extension.size() - gzip.size());
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

void require_shape_extension(const std::filesystem::path& path) {
  if (is_shape_file(path)) return;
  throw UsageError(fmt::format(
      "{}: cannot write this kind of file; name one that ends in .{}, for points .{}, or as the shape's", path.string(),
      fmt::join(written_extensions(true), ", ."), fmt::join(written_extensions(false), ", .")));
}

void require_writable(const fs::path& path) {
  const fs::path target = followed_link(path);
  std::error_code error;
  const fs::file_status old = fs::status(target, error);
  if (fs::exists(old)) {
    if (fs::is_directory(old)) fail(path, "is a folder; name a file in it");
    if (const int denied = error_of_overwriting(target); denied != 0) {
      fail(path, fmt::format("cannot be overwritten ({}); check its permissions", reason(denied)));
    }
    if (!fs::is_regular_file(old)) return;
  } else if (old.type() != fs::file_type::not_found) {
    fail(path, fmt::format("cannot be created ({}); choose another name", error.message()));
  }
  const fs::path folder = target.parent_path();
  require_writable_folder(path, folder.empty() ? "." : folder);
}

void require_different(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error) && !error) {
    throw UsageError(fmt::format("{}: named twice for different things; give two files", b.string()));
  }
}

void ProgressBar::tick(const std::stop_token& stop, const Progress& progress, std::uint64_t total, int frames,
                       const char* unit) const {
  std::mutex mutex;
  std::condition_variable_any wake;
  std::unique_lock lock(mutex);
  const auto sleep = [&](std::chrono::milliseconds time) {
    wake.wait_for(lock, stop, time, [&] { return stop.stop_requested(); });
  };
  sleep(300ms);
  if (stop.stop_requested()) return;
  std::string line;
  while (!stop.stop_requested()) {
    line = bar_line(progress.done, total != 0 ? total : progress.total.load());
    if (frames > 0) line += fmt::format("  {} of {} {}", frames_done_.load(), frames, unit);
    show(line);
    sleep(100ms);
  }
  show(fmt::format("\r{:{}}\r", "", line.size()));
}

ProgressBar::ProgressBar(const Progress& progress, std::uint64_t total, bool wanted, int frames, const char* unit) {
  if (!wanted || !shows_progress()) return;
  ticker_ =
      std::jthread([=, this, &progress](const std::stop_token& stop) { tick(stop, progress, total, frames, unit); });
}

void handle_interruptions() { when_interrupted(on_interruption); }

void end_after_last_output(bool more_to_say, std::size_t files) {
  files_at_end = count_files_in_place() + files;
  has_more_to_say = more_to_say;
  awaits_last_output = true;
}

CancelOnInterruption::CancelOnInterruption(Progress& progress) : progress_(progress) { cancellable = &progress; }

CancelOnInterruption::~CancelOnInterruption() {
  if (cancellable.exchange(nullptr) != nullptr) return;
  // A handler took it, perhaps in another thread this very moment: it must be done with before `progress` goes.
  while (!progress_.cancel) std::this_thread::yield();
}

}  // namespace knead::command
