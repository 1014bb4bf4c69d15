// Counts and sizes of a mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/math/box.h"
#include "knead/mesh/mesh.h"

namespace knead {

// An edge is an unordered pair of different vertices that follow each other in a face; a face passes through an edge
// once for each time that it traverses it.
struct Measures {
  std::size_t vertices = 0;
  std::size_t unused_vertices = 0;  // in no face
  std::size_t faces = 0;
  std::size_t triangles = 0;             // of triangulate()
  std::size_t degenerate_triangles = 0;  // a repeated index, or no area (see is_degenerate)
  std::size_t edges = 0;
  std::size_t boundary_edges = 0;        // with one face
  std::size_t nonmanifold_edges = 0;     // with more than two faces
  std::size_t misoriented_edges = 0;     // not traversed as often one way as the other, but for one face at most
  std::size_t nonmanifold_vertices = 0;  // whose faces fall into several fans (across edges of two faces)
  std::size_t components = 0;            // of faces, by shared vertices; unused vertices are none
  std::size_t boundary_loops = 0;
  std::int64_t euler = 0;  // used vertices - edges + faces
  double volume = 0;       // signed, positive where faces point outward; about the centre of the box, so that an open
                           // mesh has some finite value that means little
  double area = 0;
  std::optional<double> smallest_angle_deg;  // of all triangles but the degenerate ones; nothing where there is none
  Box box;                                   // of every vertex, used or not

  bool closed() const { return faces > 0 && boundary_edges == 0; }
  bool manifold() const { return nonmanifold_edges == 0 && nonmanifold_vertices == 0; }
  // Every edge of two or more faces is traversed as often one way as the other: a closed mesh then has a volume that
  // does not depend on the origin, manifold or not.
  bool oriented() const { return misoriented_edges == 0; }
};

// Linear in the corners but for a small sort around each vertex; sums in face order, so the same bits on every run.
Measures measure(const Mesh& mesh);

// Volume and area only, of `mesh` with other positions (same count), by the same sums.
struct VolumeAndArea {
  double volume = 0;
  double area = 0;
};
VolumeAndArea measure_volume_and_area(const Mesh& mesh, std::span<const Vec3d> positions);

// Whether a triangle has no area: its height over the longest edge is below 1e-12 of that edge, or a corner repeats.
bool is_degenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c);

// What is odd about a mesh, a sentence each, e.g. "1 edge has more than two faces"; empty for a sound closed one.
std::vector<std::string> describe_oddities(const Measures& measures);

}  // namespace knead
