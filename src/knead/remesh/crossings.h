// Finds where the surface of a patch crosses itself or the mesh around it. Internal to the remesh room.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/remesh/patch.h"

namespace knead::remesh_detail {

// A face of a surface as it is or would be.
struct PlacedFace {
  Triangle vertices{};
  std::array<Vec3d, 3> corners{};
};

inline PlacedFace placed(const Surface& s, const Triangle& vertices) {
  return {vertices, {s.after[vertices[0]], s.after[vertices[1]], s.after[vertices[2]]}};
}

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

  // What is searched: the triangles outside, then the living faces. Their vertices are numbered in this order: the
  // original vertices of the patch, the vertices outside, then those that splits have made.
  struct Triangles {
    std::vector<Triangle> triangles;
    std::vector<Vec3d> positions;      // as written
    std::vector<std::uint32_t> faces;  // of the surface

    PlacedFace placed(std::uint32_t t) const {
      const Triangle& v = triangles[t];
      return {v, {positions[v[0]], positions[v[1]], positions[v[2]]}};
    }
  };
  Triangles triangles(const Surface& surface) const;
  std::size_t outside_count() const { return outside_.size(); }
  // Returns the face with its vertices numbered so, and its corners as they are written.
  PlacedFace as_written(PlacedFace face) const;

 private:
  Vec3d as_written(const Vec3d& p) const;
  std::uint32_t number(std::uint32_t v) const {
    return v < first_ ? v : v + static_cast<std::uint32_t>(outside_positions_.size());
  }

  std::uint32_t first_ = 0;        // vertex of the patch that a split has made
  std::vector<Triangle> outside_;  // numbered after the patch's vertices
  std::vector<Vec3d> outside_positions_;
  bool single_precision_ = true;
  int threads_ = 0;
  const Progress* progress_ = nullptr;
};

}  // namespace knead::remesh_detail
