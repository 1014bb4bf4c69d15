// Ctrl-C and similar signals: ends the work and leaves no file half-written.
#pragma once

#include "knead/flow/advect.h"

namespace knead::command {

// From now on SIGINT, SIGTERM and SIGHUP (unless ignored) remove unfinished files and end the program with
// kInterrupted.
void handle_interruptions();

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
