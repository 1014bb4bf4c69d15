// Where the surface of a patch crosses itself or what is around it. Internal to the remesh room.
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

// Asked again and again while a patch changes.
class CrossingSearch {
 public:
  // Triangles of the mesh outside the patch that lie near it are kept.
  CrossingSearch(const Mesh& before, const Patch& patch, bool single_precision, int threads);

  // The pairs of triangles that cross and are not both as they were taken out, with vertices at `after`.
  Crossings find(const Patch& patch) const;

 private:
  std::vector<Triangle> outside_;  // numbered after the patch's vertices
  std::vector<Vec3d> outside_positions_;
  bool single_precision_ = true;
  int threads_ = 0;
};

}  // namespace knead::remesh_detail
