// What the sources of a deformed shape share: progress by pieces of work, normals, strokes that read the surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/session.h"
#include "knead/shape_state.h"
#include "knead/tools.h"

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

// Returns whether a normal is neither zero nor too long to be normalised.
bool has_direction(const Vec3d& normal);

// Resolves strokes that read the surface into strokes that do not.

// Returns the tool of a stamp, read from its file relative to the folder; null for other strokes. Throws InvalidInput
// where it cannot be read or is not closed.
std::shared_ptr<const Mesh> tool_mesh_of(const Stroke& stroke, const std::filesystem::path& folder);

// Returns the largest number of segments that a stroke which reads the surface becomes. `tool`: of a stamp.
std::size_t expected_segments(const Stroke& stroke, const Mesh* tool);

// Returns about as many segments as a stroke becomes, without reading any file.
std::size_t segments_about(const Stroke& stroke);

// Applies a stroke that reads the surface: passes the strokes that it becomes to surface.apply, in order, until that
// returns false. Appends remarks for the user. Returns how deep a stamp leaves the surface in its tool. Throws
// InvalidInput for a stroke that this surface cannot take.
std::optional<double> apply_on(const Stroke& stroke, const Mesh* tool, int threads, const LiveSurface& surface,
                               std::vector<std::string>& remarks);

}  // namespace knead::session_detail
