// A progress bar on a terminal.
#pragma once

#include <atomic>
#include <cstdint>
#include <stop_token>
#include <thread>

#include "knead/flow.h"

namespace knead::command {

// While it lives: a bar on standard error, drawn by a thread that watches progress.done, from 0.3 seconds on; erased
// at the end. No bar where `wanted` is false, standard error is no terminal, or the terminal is dumb. The bar has no
// colours and needs no escape codes. Behind it stands how many of the frames are done, if there are any.
class ProgressBar {
 public:
  ProgressBar(const Progress& progress, std::uint64_t total, bool wanted, int frames = 0);

  void count_frame() { ++frames_done_; }

 private:
  void tick(const std::stop_token& stop, const Progress& progress, std::uint64_t total, int frames) const;

  std::atomic<int> frames_done_{0};
  std::jthread ticker_;
};

}  // namespace knead::command
