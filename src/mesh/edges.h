// The edges of a mesh and the faces at them; checks, volumes and normals that other modules share.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "knead/mesh.h"

namespace knead {

// One use of an edge by a face: the face runs along the edge from corner `corner` to its next corner.
struct EdgeUse {
  std::uint32_t low = 0;   // the smaller vertex of the edge
  std::uint32_t high = 0;  // the larger vertex of the edge
  std::uint32_t corner = 0;
  std::uint32_t next_corner = 0;
  bool upward = false;  // the face runs from low to high
};

// A corner of a face, and those before and after it.
struct StarCorner {
  std::uint32_t corner = 0;
  std::uint32_t next = 0;
  std::uint32_t previous = 0;
  std::uint32_t next_vertex = 0;
  std::uint32_t previous_vertex = 0;
};

// The corners of a mesh sorted by vertex, in parts that several threads may read at once. A part has the corners at
// some thousand consecutive vertices.
class CornerParts {
 public:
  // Time: linear. Memory: 4 bytes for each corner. The mesh must outlive the parts. threads as for parallel_for.
  CornerParts(const Mesh& mesh, int threads);

  std::size_t count() const { return begin_.size() - 1; }

  // Calls visit(vertex, star) for each vertex of the part in order, with the corners at it in their order.
  void visit_stars(std::size_t part,
                   const std::function<void(std::uint32_t, std::span<const StarCorner>)>& visit) const;

  // Calls visit(uses) once for each edge whose smaller vertex is in the part, as for_each_edge() does.
  void visit_edges(std::size_t part, const std::function<void(std::span<const EdgeUse>)>& visit) const;

 private:
  const Mesh& mesh_;
  std::vector<std::uint32_t> begin_;          // of each part, in corners_
  std::unique_ptr<std::uint32_t[]> corners_;  // in the order of parts, then ascending
};

// Returns true if measure(mesh) is closed() and oriented(), in less time. threads as for parallel_for.
bool is_closed_and_oriented(const Mesh& mesh, int threads = 0);

// Returns the relative change of a volume; nothing if the volume before is only a rounding error, as that of a sheet
// with two sides.
std::optional<double> volume_change(const VolumeAndArea& before, double after);

// Calls visit(uses) once for each edge, with all its uses in the order of corners; edges come in the order of their
// smaller, then their larger vertex. A corner followed by the same vertex has no edge. Time: linear, plus a sort of the
// few uses at each vertex. Memory: 4 bytes for each corner.
void for_each_edge(const Mesh& mesh, const std::function<void(std::span<const EdgeUse>)>& visit);

// Disjoint sets of the numbers from 0 to count - 1. Method: union by smaller number, path halving.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count = 0) { reset(count); }

  // Makes each number a set of its own.
  void reset(std::size_t count) {
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  // Returns the smallest number in the set of i.
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // Unites the sets of a and b.
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a < b) parent_[b] = a;
    if (b < a) parent_[a] = b;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// Throws InvalidInput, with the number of the first element at fault, unless the faces of the mesh are sound and there
// is one finite position for each vertex. Does not look at attributes. Time: a pass over corners and positions.
void require_sound(const Mesh& mesh, std::span<const Vec3d> positions);

// Does the same, but the positions may be any numbers.
void require_faces(const Mesh& mesh, std::span<const Vec3d> positions);

// Returns the normals of these vertices, whose numbers ascend, bit for bit as vertex_normals() does. Memory: a bit for
// each vertex of the mesh.
std::vector<Vec3d> normals_of(const Mesh& mesh, std::span<const Vec3d> positions,
                              std::span<const std::uint32_t> vertices);

}  // namespace knead
