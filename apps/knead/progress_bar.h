// A progress bar on a terminal.
#pragma once

#include <cstdint>
#include <thread>

#include "knead/flow/advect.h"

namespace knead::command {

// While it lives: a bar on standard error, drawn by a thread that watches progress.done, from 0.3 seconds on; erased
// at the end. No bar where `wanted` is false, standard error is no terminal, or the terminal is dumb. The bar has no
// colours and needs no escape codes.
class ProgressBar {
 public:
  ProgressBar(const Progress& progress, std::uint64_t total, bool wanted);

 private:
  std::jthread ticker_;
};

}  // namespace knead::command
