// Inside of DeformedShape: progress by pieces of work, and normals that the flow carries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/replay.h"

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

// Puts the count of the work around it back when work that counts its own steps ends.
class KeptCount {
 public:
  explicit KeptCount(Progress* progress) : progress_(progress) {
    if (progress_ == nullptr) return;
    done_ = progress_->done;
    total_ = progress_->total;
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

// Normals carried by the flow.

// Returns whether a normal is neither zero nor too long to be normalised.
bool has_direction(const Vec3d& normal);

// Places four points around every point whose normal has a direction; as many normals as positions. `reach`: a length
// above 0. The error of a turned normal falls with its square until rounding takes over.
TransportedNormals carry_normals(std::span<const Vec3d> positions, std::vector<Vec3d> normals, double reach);

// Returns the normals as the points show them now; lengths are kept. A normal keeps its bits if its points did not
// move, or were torn apart (at the wall of a limit cylinder).
std::vector<Vec3d> turned_normals(const TransportedNormals& carried);

// The same of one vertex.
Vec3d turned_normal(const TransportedNormals& carried, std::uint32_t vertex);

}  // namespace knead::session_detail
