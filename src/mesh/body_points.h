// Evenly spread points of a body: inside its surface and on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

struct BodyPointsOptions {
  std::size_t inside = 3000;  // about so many points inside
  double most_spacing = 0;    // but not farther apart than this; 0: no limit
  double shell_depth = 0;     // how far below an open surface its second layer lies
  int threads = 0;            // as for parallel_for
  // Only points in or next to this box, `most_spacing` apart; no shell stands for an open surface.
  std::optional<Box> within{};
};

struct BodyPoints {
  std::vector<Vec3d> points;
  std::size_t inside = 0;  // the first so many points are inside; the others are on the surface
  bool is_closed = true;   // false: no inside was found, and a shell of the surface stands for the body
};

// Returns points of the body that the triangles bound. A lattice that is turned against the axes gives the points
// inside: a point is inside if that is so along two or three of the lattice's lines through it, which makes small holes
// harmless, as well as a surface that is inside out. Where the surface is open (there is hardly anything inside) or
// there are no triangles, the points are those of the surface or cloud, and a second layer `shell_depth` below it where
// there are triangles with area. There is at least one point if there are positions. The points do not depend on the
// order of vertices and triangles, but for rounding.
// Time: about 5 us for each point inside, besides a SurfaceTree of the triangles.
BodyPoints body_points(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                       const BodyPointsOptions& options);

// Returns the numbers of at most about `count` of the points, evenly spread: of each cell of a lattice the point
// nearest to its middle, in the order of the cells. They depend on the set of points, not on their order.
std::vector<std::uint32_t> spread_points(std::span<const Vec3d> points, std::size_t count);

// Returns the same for a lattice of this spacing, a length above the 2^-20th part of the points' extent.
std::vector<std::uint32_t> points_apart(std::span<const Vec3d> points, double spacing);

}  // namespace knead
