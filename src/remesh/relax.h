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

namespace knead::detail {

// The topology of a mesh that relaxing needs; it does not depend on positions.
struct RelaxTopology {
  // A vertex of a crease that has two neighbours on the crease.
  struct OnCrease {
    std::uint32_t vertex = 0;
    std::array<std::uint32_t, 2> neighbours{};
  };

  // stays: at boundaries, at ends and corners of creases, at edges of more than two faces, and where faces disagree
  // which side is outside.
  enum class Freedom : std::uint8_t { free, on_crease, stays };

  std::vector<std::uint32_t> corner_begin;  // of each vertex, in `corners`; and the end
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

// Relaxes a surface dab by dab.
//
// Each iteration moves each vertex within the radius towards the mean of its neighbours, most in the centre. Then all
// of them move along their normals, by their weights times a common factor that restores the volume (up to rounding;
// for a surface with boundaries, which rest, the volume between it and any point). A vertex rests if a triangle would
// turn by more than 45 degrees or become much thinner. Vertices on a straight crease move along it. If a dab makes
// triangles cross that did not before, it is repeated without the vertices there, and undone in the end.
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

}  // namespace knead::detail
