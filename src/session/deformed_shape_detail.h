// Parts of the sources of a deformed shape: progress by pieces of work, splats that moved, and normals.
#pragma once

#include <cstdint>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"

namespace knead::detail {

// Counts pieces of work in Progress::done, and replaces what the work itself adds there.
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

// Keeps the count of a progress during work that counts its own steps, and restores it at the end. `hides_total` sets
// the total to 0 in between.
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

}  // namespace knead::detail
