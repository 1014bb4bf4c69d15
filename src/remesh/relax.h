// Smooths a surface by moving its vertices; its faces stay. Internal to the library.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/vec.h"

namespace knead::remesh_detail {

// What relaxing needs to know of a mesh, whatever the positions of its vertices.
struct RelaxTopology {
  // A vertex of a crease that has two neighbours on the crease.
  struct OnCrease {
    std::uint32_t vertex = 0;
    std::array<std::uint32_t, 2> neighbours{};
  };

  // stays: at boundaries, ends and corners of creases, edges of more than two faces, faces that disagree about outside.
  enum class Freedom : std::uint8_t { free, on_crease, stays };

  std::vector<std::uint32_t> corner_begin;  // of each vertex, in `corners`; one more than vertices
  std::vector<std::uint32_t> corners;       // 3 t + i: the vertex is corner i of triangle t; ascending for each vertex
  std::vector<Freedom> freedom;             // of each vertex
  std::vector<OnCrease> on_crease;          // ascending by vertex

  std::span<const std::uint32_t> corners_of(std::uint32_t v) const {
    return std::span(corners).subspan(corner_begin[v], corner_begin[v + 1] - corner_begin[v]);
  }
};

// Returns the topology. Time: n log n for the largest number of triangles at one vertex.
RelaxTopology relax_topology(std::span<const Triangle> triangles, std::size_t vertices,
                             std::span<const MeshEdge> creases);

// One place where the surface is relaxed. The members are those of RelaxStroke.
struct RelaxDab {
  Vec3d center;
  double radius = 0;
  double amount = 0.5;
  double surface = 1;
  int iterations = 2;
};

// Relaxes a surface at one place after the other.
//
// Each iteration moves each vertex within the radius towards the mean of its neighbours, most in the middle. Then all
// of them move along their normals by a common factor of their weights, so that the volume is what it was (up to
// rounding; of a surface with boundaries, the volume between it and any point, while the boundaries rest). A vertex
// rests if a triangle would turn by more than 45 degrees or become much thinner. Vertices on a straight crease move
// along it. A dab that makes triangles cross that did not is repeated without the vertices there, at last undone.
class Relaxer {
 public:
  // The arguments must outlive this. `positions`, one for each vertex, are changed. `single_precision`: triangles must
  // not cross with positions rounded to float. Linear time.
  Relaxer(const RelaxTopology& topology, std::span<const Triangle> triangles, std::span<Vec3d> positions,
          bool single_precision, int threads);

  // Relaxes the surface at one place. The result depends on the positions and the dab only, bit for bit. Time: that of
  // the vertices within the radius and of a search for crossings among the triangles around.
  void apply(const RelaxDab& dab);

 private:
  class Patch;

  Box chunk_box(std::size_t chunk) const;
  std::vector<std::uint32_t> vertices_within(const RelaxDab& dab) const;
  std::vector<std::uint32_t> triangles_in(const Box& box) const;

  const RelaxTopology& topology_;
  std::span<const Triangle> triangles_;
  std::span<Vec3d> positions_;
  bool single_precision_ = true;
  int threads_ = 0;
  std::vector<Box> boxes_;             // of each chunk of triangles
  std::vector<std::uint32_t> number_;  // of vertices and triangles in the current patch; kNone outside
  std::vector<std::uint32_t> triangle_number_;
};

// The part of a surface that one dab relaxes.

// The vertices that a dab may move, then those around them; and the triangles at the vertices that may move.
struct RelaxPatch {
  using Neighbours = std::array<std::uint32_t, 2>;

  std::vector<double> weight;          // of each vertex that may move, from 0 to 1
  std::vector<Neighbours> crease;      // of each vertex that may move: its neighbours on a crease; kNone: it is on none
  std::vector<Vec3d> positions;        // of all vertices
  std::vector<Triangle> triangles;     // by these numbers of vertices
  std::vector<std::uint32_t> begin;    // of each vertex that may move, in `corners`; one more
  std::vector<std::uint32_t> corners;  // 3 t + i: the vertex is corner i of triangle t

  std::size_t moving() const { return weight.size(); }
};

// Moves the vertices once towards the means of their neighbours, and keeps the volume (Relaxer).
void relax_once(RelaxPatch& patch, double amount, double surface, int threads);

}  // namespace knead::remesh_detail
