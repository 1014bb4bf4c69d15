// Ctrl-C and similar signals: ends the work and leaves no file half-written.
#pragma once

#include <cstddef>

#include "knead/flow.h"

namespace knead::command {

// From now on SIGINT, SIGTERM and SIGHUP (unless ignored) remove unfinished files and end the program with
// kInterrupted.
void handle_interruptions();

// Call before the last file is written: an interruption that comes when it is in place, or when so many files are that
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
