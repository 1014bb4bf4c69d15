// Progress by pieces of work. Internal to the session room.
#pragma once

#include <cstdint>

#include "knead/math/progress.h"

namespace knead::session_detail {

// Counts pieces of work, whatever the work itself adds to Progress::done meanwhile.
class Counted {
 public:
  Counted(Progress* progress, std::uint64_t total) : progress_(progress) {
    if (progress_ == nullptr) return;
    progress_->done = 0;
    progress_->total = total;
  }
  ~Counted() {
    if (progress_ != nullptr) progress_->total = 0;
  }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

  void add(std::uint64_t work) {
    done_ += work;
    if (progress_ != nullptr) progress_->done = done_;
  }

 private:
  Progress* progress_;
  std::uint64_t done_ = 0;
};

}  // namespace knead::session_detail
