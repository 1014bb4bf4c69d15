// Splitting edges where the deformation needs it. Internal to the remesh room.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "knead/remesh/remesh.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// The middles of edges where the deformation carries them, kept for every edge as long as it lives.
class Refinement {
 public:
  // With `whole` also edges that do not move are held against the greatest length.
  Refinement(Surface& surface, const Deformation& deformation, const RemeshTargets& targets, bool whole);

  // Splits until no edge is above the targets, or a limit is reached; whether none is.
  bool refine();

  // Splits the edges of these faces once, whatever their length, and goes on as refine.
  bool refine_faces(std::span<const std::uint32_t> faces);

  // Of each edge: from the middle of its chord to where its middle is carried; zero where it is locked.
  const std::vector<Vec3d>& deviations() const { return deviation_; }

  // Of a surface that was put back to what it was when these were its deviations.
  void put_back(std::vector<Vec3d> deviations) { deviation_ = std::move(deviations); }

  std::size_t splits() const { return splits_; }

 private:
  void carry_middles();
  bool split_round(const std::vector<bool>& forced);
  std::vector<std::uint32_t> find_marked(const std::vector<bool>& forced);
  std::vector<std::uint32_t> find_edges_of_large_faces() const;
  bool is_moved(std::uint32_t e) const;
  bool is_above(std::uint32_t e, const std::vector<Vec3d>& normals_before,
                const std::vector<Vec3d>& normals_after) const;
  std::vector<std::uint32_t> with_longest_of_caps(const std::vector<std::uint32_t>& marked) const;
  void split_edge(std::uint32_t e);
  bool is_open(std::uint32_t e) const;
  double length2(std::uint32_t e, const std::vector<Vec3d>& positions) const;

  Surface& s_;
  const Deformation& deformation_;
  RemeshTargets targets_;
  bool whole_ = false;
  double shortest_ = 0;  // no edge shorter than twice this is split
  std::size_t most_vertices_ = 0;
  std::vector<Vec3d> deviation_;
  std::vector<std::uint32_t> fresh_;     // edges that were not carried yet
  std::vector<std::uint32_t> untested_;  // edges that were, and were not held against the targets since
  std::size_t splits_ = 0;
};

}  // namespace knead::remesh_detail
