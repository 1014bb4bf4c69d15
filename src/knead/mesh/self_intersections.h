// Finds the pairs of triangles in which a surface intersects itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/progress.h"
#include "knead/math/vec3.h"
#include "knead/mesh/triangulate.h"

namespace knead {

// Threads, the greatest number of pairs, and which triangles to look at.
struct SelfIntersectionOptions {
  int threads = 0;                            // 0: as many as the machine has
  std::size_t limit = 10'000'000;             // the search stops after this many pairs
  const Progress* progress = nullptr;         // cancels the search, which then throws Cancelled
  const std::vector<bool>* chosen = nullptr;  // for each triangle: finds only pairs with a chosen one; null: all
};

// The pairs of triangles that cross.
struct SelfIntersections {
  std::vector<std::array<std::uint32_t, 2>> pairs;  // numbers of triangles, the smaller first, sorted; each pair once
  std::size_t count = 0;                            // of pairs; at most the limit
  bool complete = true;  // false if there are more pairs than the limit; `pairs` is then empty
};

// Returns the pairs of triangles that intersect in more than the vertices and edges they share. Vertices are shared if
// their numbers are equal. Two triangles are a pair
// - without a common vertex: if they have a common point; touching counts;
// - with one common vertex: if the edge opposite to it in one triangle meets the other triangle;
// - with two: if they lie in one plane on the same side of the common edge;
// - with three: always.
// A triangle whose corners are collinear is a pair with itself and with no other triangle. CGAL 5.5
// (Polygon_mesh_processing::self_intersections) returns the same pairs, also for edges with more than two triangles.
//
// Throws InvalidInput where check_triangles() does. Every decision is exact (predicates.h); coordinates below 2^-250
// (about 1e-75) of the largest one count as 0. The result is the same for every number of threads. Use the triangles of
// triangulate(mesh); the same triangles with two sets of positions compare a mesh before and after a deformation.
//
// Time: about n log n for surfaces, n + k log k with k chosen triangles; in the worst case quadratic in the number of
// triangles whose boxes overlap (a fan of k triangles: k^2 / 2).
SelfIntersections self_intersections(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                     const SelfIntersectionOptions& options = {});

}  // namespace knead
