#include "interrupt.h"

#include <array>
#include <atomic>
#include <thread>

#include "command.h"
#include "knead/io/atomic_file.h"
#include "program.h"

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
    end_process(kDone);
  }
  discard_unfinished_files();
  write_error_output("knead: interrupted\n");
  end_process(kInterrupted);
}

}  // namespace

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
