// Finds where the surface of a patch crosses itself or the mesh around it, and refuses changes that would make it
// cross.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/vec.h"
#include "mesh/box_tree.h"
#include "remesh/patch.h"

namespace knead::detail {

// A face of a surface, or a proposed one, with the positions of its corners.
struct PlacedFace {
  Triangle vertices{};
  std::array<Vec3d, 3> corners{};
};

inline PlacedFace placed(const Surface& s, const Triangle& vertices) {
  return {vertices, corners_of(vertices, s.after)};
}

// The triangles that cross.
struct Crossings {
  std::size_t pairs = 0;
  std::size_t curves = 0;            // sets of pairs that are connected by vertices
  std::vector<std::uint32_t> faces;  // of the patch, ascending
};

// Searches the crossings of a patch while it changes. The mesh around the patch is prepared once.
class CrossingSearch {
 public:
  // Stores the triangles of the mesh that are outside the patch and near it.
  CrossingSearch(const Mesh& before, const Patch& patch, bool single_precision, int threads,
                 const Progress* progress = nullptr);

  // Returns the pairs of triangles that cross with vertices at `after`. Pairs of two unchanged triangles do not count.
  // `only`: a flag for each face of the patch; only pairs with a flagged face count. Empty: all faces are flagged.
  Crossings find(const Patch& patch, const std::vector<bool>& only = {}) const;

  // The triangles to search: those outside, then the faces that are alive. Their vertices are numbered in this order:
  // the original vertices of the patch, the vertices outside, then those that splits have made.
  struct Triangles {
    std::vector<Triangle> triangles;
    std::vector<Vec3d> positions;      // as written
    std::vector<std::uint32_t> faces;  // of the surface
    std::size_t outside = 0;           // triangles before those of the faces

    PlacedFace placed(std::uint32_t t) const { return {triangles[t], corners_of(triangles[t], positions)}; }
  };
  // Returns the triangles to search; with a box only those whose boxes overlap it.
  Triangles triangles(const Surface& surface, const std::optional<Box>& box = {}) const;
  int threads() const { return threads_; }
  // Returns a position as it is written.
  Vec3d as_written(const Vec3d& p) const;
  // Returns the face with its vertices numbered in this way, and its corners as they are written.
  PlacedFace as_written(PlacedFace face) const;

 private:
  std::uint32_t number(std::uint32_t v) const {
    return v < first_ ? v : v + static_cast<std::uint32_t>(outside_positions_.size());
  }

  std::uint32_t first_ = 0;        // the first vertex of the patch that a split has made
  std::vector<Triangle> outside_;  // numbered after the patch's vertices
  std::vector<Vec3d> outside_positions_;
  bool single_precision_ = true;
  int threads_ = 0;
  const Progress* progress_ = nullptr;
};

// Refuses changes of a surface that would make triangles cross. It tests only the triangles near a change. Whoever
// changes the surface must tell the guard.
class CrossingGuard {
 public:
  // The surface of the patch and the search must outlive the guard. It watches nothing yet.
  CrossingGuard(const Surface& surface, const CrossingSearch& search);

  // Watches the vertices of all faces whose boxes overlap one of these, and every vertex that a split makes.
  void watch(std::span<const Box> places);
  void watch_everything() { watched_.clear(); }

  // Returns true if the proposed faces may take the place of `faces`: if no vertex of `faces` is watched, if no
  // proposed face crosses another triangle, or if the proposed ones cross fewer than `faces` do. A face without area
  // counts as a pair.
  bool allows(std::span<const std::uint32_t> faces, std::span<const PlacedFace> proposed);
  // Returns this for the faces around vertices that move by d.
  bool allows_move(std::span<const std::uint32_t> vertices, const Vec3d& d);

  // Returns true if the face is alive and crosses another triangle.
  bool crosses(std::uint32_t face);

  // Returns true if the limit on tested pairs is reached, because nearly every pair of faces overlaps. Improving such a
  // surface further would take long and not help.
  bool is_spent() const { return tests_ > max_tests_; }

  // Call this after a face, or those around a vertex, have changed.
  void update(std::uint32_t face);
  void update_around(std::uint32_t v);
  // Call this first for a face that a split has made from another.
  void add(std::uint32_t face, std::uint32_t from);
  // Call this for a face before it is removed.
  void remove(std::uint32_t face);

 private:
  CrossingGuard(const Surface& surface, const CrossingSearch& search, const CrossingSearch::Triangles& all);

  // A triangle that others may cross: one outside the patch, or a face.
  struct Obstacle {
    FloatBox box;                // empty: removed, or without area
    std::uint32_t next = kNone;  // the next one that the same place of the tree holds
    std::uint32_t mark = 0;      // the number of the last mark() with this one
  };
  struct Boxed {
    PlacedFace triangle;
    FloatBox box;
  };

  bool is_watched(std::uint32_t v) const { return v >= watched_.size() || watched_[v]; }
  void set(std::uint32_t obstacle, const PlacedFace& written);
  void mark(std::span<const std::uint32_t> faces);
  // Returns the number of crossing pairs of the faces with each other and with all obstacles that are not marked. Stops
  // at `enough`.
  std::size_t count_pairs(std::span<const PlacedFace> faces, std::size_t enough);
  bool cross(const Boxed& face, const FloatBox& box, const PlacedFace& triangle);

  const Surface& s_;
  const CrossingSearch& search_;
  BoxTree tree_;
  // The first obstacles are in the order of their places in the tree: near in space is near in memory.
  std::vector<Obstacle> obstacles_;
  std::vector<PlacedFace> written_;         // as they are written, numbered as by the search
  std::vector<std::uint32_t> place_;        // of each obstacle in the tree
  std::vector<std::uint32_t> face_;         // of each place in the tree, or kNone
  std::vector<std::uint32_t> obstacle_of_;  // of each face
  std::vector<bool> watched_;               // of each vertex when the guard was made; later vertices are watched
  std::uint32_t mark_ = 0;
  std::vector<Boxed> faces_;
  std::uint64_t tests_ = 0;  // of pairs whose boxes overlap
  std::uint64_t max_tests_;
};

}  // namespace knead::detail
