// Splits edges until a mesh can follow a deformation, and the deadline of a remesh.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/remesh.h"
#include "remesh/facets.h"
#include "remesh/surface.h"

namespace knead::detail {

// The time after which a remesh ends with the best surface so far, counted from construction. Several threads may ask.
class Deadline {
 public:
  // Infinity: never.
  explicit Deadline(double seconds) : seconds_(seconds) {}

  // Returns true if the time is over.
  bool is_over() {
    if (seconds_ > kMaxSeconds) return false;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    if (passed.count() >= seconds_) has_ended_work_ = true;
    return has_ended_work_;
  }

  // Returns true if is_over() has ever returned true: then a loop has ended early.
  bool has_ended_work() const { return has_ended_work_; }

 private:
  static constexpr double kMaxSeconds = 1e9;  // 30 years

  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double seconds_;
  std::atomic<bool> has_ended_work_ = false;
};

// What limit_edges() did.
struct LimitedEdges {
  std::size_t splits = 0;
  bool met = true;  // no edge is longer than the limit
};

// Splits edges in their middle, the longest first, until none is longer than options.targets.max_edge: those with a
// moved end, or with options.whole all. The surface keeps its form. Does not split locked edges, and stops at
// options.targets.max_vertices, of which `outside` are outside the surface. Uses `threads` and `progress` of the
// options, too. Copies the surface to `was` before the first split.
LimitedEdges limit_edges(Surface& surface, const RemeshOptions& options, std::size_t outside,
                         std::optional<Surface>& was);

// Splits edges of a surface. It keeps, for every edge, where the deformation moves its middle.
class Refinement {
 public:
  // Of the options: `targets`; `whole`, by which edges that do not move must also be shorter than targets.max_edge;
  // `threads`; and `progress`, which cancels. `outside`: vertices of the mesh outside the surface, which count towards
  // targets.max_vertices. No round begins after the deadline.
  Refinement(Surface& surface, const Deformation& deformation, const RemeshOptions& options, std::size_t outside,
             Deadline& deadline);

  // Splits edges until all meet the targets, or a limit on rounds or the deadline is reached. Returns true if all do.
  // Throws RemeshLimit before a round if that would exceed the limits on vertices or work, or if all rounds probably
  // would.
  bool refine();

  // Splits the edges of these faces once, whatever their length, then continues as refine(), but stops at the limits.
  bool refine_faces(std::span<const std::uint32_t> faces);

  // Returns for each edge the vector from the middle of its chord to the moved middle of the edge; zero if locked.
  const std::vector<Vec3d>& deviations() const { return deviation_; }

  // Restores the deviations after the caller has restored the surface that they belong to.
  void restore(std::vector<Vec3d> deviations) { deviation_ = std::move(deviations); }

  std::size_t splits() const { return splits_; }
  std::size_t flips() const { return flips_; }

 private:
  // How a round ended.
  enum class Round { split, met, stopped };
  // Factors by which the estimate lengthens the targets.
  struct Slack {
    double edge = 1;
    double chord = 1;
  };

  bool carry_middles();
  Round split_round(const std::vector<bool>& forced);
  bool split_rounds();
  bool has_room(std::span<const std::uint32_t> marked);
  double room() const;
  double points_left() const;
  double pieces(std::uint32_t e, const Slack& slack) const;
  double estimate(std::span<const std::uint32_t> edges, const Slack& slack) const;
  std::string remedy(std::span<const std::uint32_t> edges, double max_vertices) const;
  [[noreturn]] void refuse(std::span<const std::uint32_t> edges, double needed) const;
  std::vector<std::uint32_t> find_marked(const std::vector<bool>& forced);
  std::optional<std::vector<std::uint32_t>> find_edges_of_large_faces() const;
  bool is_moved(std::uint32_t e) const;
  double distance_from_image(std::uint32_t e) const;
  double distance_from_face(std::uint32_t f, const Vec3d& deviation) const;
  // `normals`: those of the vertices after the deformation.
  bool needs_split(std::uint32_t e, const std::vector<Vec3d>& normals) const;
  std::vector<std::uint32_t> with_longest_of_caps(const std::vector<std::uint32_t>& marked) const;
  void split_edge(std::uint32_t e);
  bool is_open(std::uint32_t e) const;
  double length2(std::uint32_t e, const std::vector<Vec3d>& positions) const;

  Surface& s_;
  const Deformation& deformation_;
  RemeshTargets targets_;
  bool whole_;
  int threads_;
  const Progress* progress_;
  Deadline& deadline_;
  double min_length_;       // edges shorter than twice this length are not split
  double flat_cosine2_;     // the squared cosine of an angle that is certainly below targets.max_angle
  double outside_;          // vertices of the mesh outside the surface
  bool may_refuse_ = true;  // else stops at the limits
  double carried_ = 0;      // middles
  std::vector<Vec3d> deviation_;
  std::vector<std::uint32_t> uncarried_;  // edges whose middle has not been moved yet
  std::vector<std::uint32_t> untested_;   // edges whose middle has been moved, not yet compared with the targets
  std::optional<FlatFlips> flat_;         // unless nothing may be flipped
  std::size_t splits_ = 0;
  std::size_t flips_ = 0;
};

}  // namespace knead::detail
