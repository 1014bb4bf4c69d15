// Where a surface passes through itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/vec3.h"
#include "knead/mesh/triangulate.h"

namespace knead {

struct SelfIntersectionOptions {
  int threads = 0;  // 0: all of the machine's
  std::size_t limit = 10'000'000;
};

struct SelfIntersections {
  std::vector<std::array<std::uint32_t, 2>> pairs;  // numbers of triangles, the smaller first, sorted; each pair once
  std::size_t count = 0;                            // of pairs, or the limit
  bool complete = true;                             // false: there are more than the limit; pairs is then empty
};

// The pairs of triangles that intersect beyond what they share by vertex number:
// - without a common vertex: the closed triangles have a point in common; touching counts;
// - with one: the edge that lies opposite to the common vertex in one of them meets the other;
// - with two: they lie in one plane, on the same side of the common edge, and so cover a part of each other;
// - with three: always.
// A triangle whose corners lie on one line is a pair with itself and with no other. These are the pairs of
// self_intersections() in CGAL 5.5's Polygon_mesh_processing, for any triangles: also where more than two share an
// edge.
//
// Exact: every decision is by predicates.h. Coordinates below 2^-250 of the largest in magnitude (about 1e-75) count as
// 0. The same for every number of threads. Positions are finite. Triangles that come from triangulate(mesh) are
// numbered as there; the same ones with other positions compare a mesh before and after a deformation.
//
// Time: about n log n for surfaces, the square of the number of triangles whose boxes overlap at the worst (a fan of k
// triangles: k^2 / 2). The search ends at the first pair beyond the limit.
SelfIntersections self_intersections(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                     const SelfIntersectionOptions& options = {});

}  // namespace knead
