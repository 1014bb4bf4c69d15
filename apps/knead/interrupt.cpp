#include "interrupt.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <string_view>
#include <thread>

#include "command.h"
#include "knead/io.h"

namespace knead::command {
namespace {

// What the next interruption cancels. A signal handler can be reached through nothing else.
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
    ::_exit(kDone);
  }
  discard_unfinished_files();
  constexpr std::string_view message = "knead: interrupted\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, message.data(), message.size());
  ::_exit(kInterrupted);
}

}  // namespace

void handle_interruptions() {
  struct sigaction action {};
  action.sa_handler = on_interruption;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
  struct sigaction old {};
  if (::sigaction(SIGHUP, nullptr, &old) == 0 && old.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
}

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
