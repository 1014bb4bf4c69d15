// Finds where the surface of a patch crosses itself or the mesh around it. Internal to the remesh room.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/remesh/patch.h"

namespace knead::remesh_detail {

struct Crossings {
  std::size_t pairs = 0;
  std::vector<std::uint32_t> faces;  // of the patch, ascending
};

// Searches the crossings of a patch while it changes. The mesh around the patch is prepared once.
class CrossingSearch {
 public:
  // Stores the triangles of the mesh that are outside the patch and near it.
  CrossingSearch(const Mesh& before, const Patch& patch, bool single_precision, int threads,
                 const Progress* progress = nullptr);

  // Returns the pairs of triangles that cross with vertices at `after`. Pairs of two unchanged triangles do not count.
  Crossings find(const Patch& patch) const;

 private:
  std::vector<Triangle> outside_;  // numbered after the patch's vertices
  std::vector<Vec3d> outside_positions_;
  bool single_precision_ = true;
  int threads_ = 0;
  const Progress* progress_ = nullptr;
};

}  // namespace knead::remesh_detail
