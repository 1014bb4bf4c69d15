// Splits edges until a mesh can follow a deformation. Internal to the remesh room.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "knead/remesh/remesh.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// Splits edges of a surface. It keeps, for every edge, where the deformation moves its middle.
class Refinement {
 public:
  // If `whole`, edges that do not move must also be shorter than targets.max_edge. `progress` cancels.
  Refinement(Surface& surface, const Deformation& deformation, const RemeshTargets& targets, bool whole,
             const Progress* progress = nullptr);

  // Splits edges until all meet the targets, or a limit on vertices or rounds is reached. Returns true if all do.
  bool refine();

  // Splits the edges of these faces once, whatever their length, then continues as refine().
  bool refine_faces(std::span<const std::uint32_t> faces);

  // Returns for each edge the vector from the middle of its chord to the moved middle of the edge; zero if locked.
  const std::vector<Vec3d>& deviations() const { return deviation_; }

  // Restores the deviations after the caller has restored the surface that they belong to.
  void put_back(std::vector<Vec3d> deviations) { deviation_ = std::move(deviations); }

  std::size_t splits() const { return splits_; }

 private:
  void carry_middles();
  bool split_round(const std::vector<bool>& forced);
  std::vector<std::uint32_t> find_marked(const std::vector<bool>& forced);
  std::vector<std::uint32_t> find_edges_of_large_faces() const;
  bool is_moved(std::uint32_t e) const;
  bool needs_split(std::uint32_t e, const std::vector<Vec3d>& normals_before,
                   const std::vector<Vec3d>& normals_after) const;
  std::vector<std::uint32_t> with_longest_of_caps(const std::vector<std::uint32_t>& marked) const;
  void split_edge(std::uint32_t e);
  bool is_open(std::uint32_t e) const;
  double length2(std::uint32_t e, const std::vector<Vec3d>& positions) const;

  Surface& s_;
  const Deformation& deformation_;
  RemeshTargets targets_;
  bool whole_ = false;
  const Progress* progress_ = nullptr;
  double shortest_ = 0;  // edges shorter than twice this length are not split
  std::size_t most_vertices_ = 0;
  std::vector<Vec3d> deviation_;
  std::vector<std::uint32_t> uncarried_;  // edges whose middle has not been moved yet
  std::vector<std::uint32_t> untested_;   // edges whose middle has been moved, not yet compared with the targets
  std::size_t splits_ = 0;
};

}  // namespace knead::remesh_detail
