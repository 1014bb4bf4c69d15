// What the sources of a deformed shape share: progress by pieces of work, and normals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"

namespace knead::session_detail {

// Counts pieces of work, whatever the work itself adds to Progress::done meanwhile.
class ScopedProgress {
 public:
  ScopedProgress(Progress* progress, std::uint64_t total) : progress_(progress) {
    if (progress_ == nullptr) return;
    progress_->done = 0;
    progress_->total = total;
  }
  ~ScopedProgress() {
    if (progress_ != nullptr) progress_->total = 0;
  }
  ScopedProgress(const ScopedProgress&) = delete;
  ScopedProgress& operator=(const ScopedProgress&) = delete;

  void add(std::uint64_t work) {
    done_ += work;
    if (progress_ != nullptr) progress_->done = done_;
  }

 private:
  Progress* progress_;
  std::uint64_t done_ = 0;
};

// Puts the count of the work around it back when work that counts its own steps ends. The total is 0 meanwhile if it is
// hidden.
class KeptCount {
 public:
  explicit KeptCount(Progress* progress, bool hides_total = false) : progress_(progress) {
    if (progress_ == nullptr) return;
    done_ = progress_->done;
    total_ = progress_->total;
    if (hides_total) progress_->total = 0;
  }
  ~KeptCount() {
    if (progress_ == nullptr) return;
    progress_->done = done_;
    progress_->total = total_;
  }
  KeptCount(const KeptCount&) = delete;
  KeptCount& operator=(const KeptCount&) = delete;

 private:
  Progress* progress_;
  std::uint64_t done_ = 0;
  std::uint64_t total_ = 0;
};

// Splats that a flow may reach, their centres after it, and its Jacobian at each.
struct MovedSplats {
  std::vector<std::uint32_t> vertices;
  std::vector<Vec3d> centers;
  std::vector<Mat3d> jacobians;
};

// Returns whether a normal is neither zero nor too long to be normalised.
bool has_direction(const Vec3d& normal);

}  // namespace knead::session_detail
