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

// How many points body_points() makes, and where. Lengths are in the units of the shape.
struct BodyPointsOptions {
  std::size_t inside = 3000;  // about this many points are made inside
  double most_spacing = 0;    // the greatest distance between neighbours; 0: no limit
  double shell_depth = 0;     // depth of the second layer below an open surface
  int threads = 0;            // as for parallel_for
  // Makes only points in or next to this box, `most_spacing` apart. An open surface then gets no second layer.
  std::optional<Box> within{};
};

// The points of a body.
struct BodyPoints {
  std::vector<Vec3d> points;  // those inside, then those on the surface
  std::size_t inside = 0;     // the number of points inside
  bool is_closed = true;      // false: no inside was found, so two layers at the surface represent the body
};

// Returns points of the body that the triangles bound. The points inside belong to a lattice that is turned against the
// axes: a point is inside if at least two of the three lattice lines through it say so. This tolerates small holes, and
// surfaces that are inside out. If less than half of the volume is found inside (an open surface), or there are no
// triangles, the points are those of the surface or cloud, with a second layer `shell_depth` below triangles that have
// an area. Returns at least one point if there are positions. The order of vertices and triangles affects only the
// rounding. Time: about 5 us for each point inside, besides a SurfaceTree of the triangles.
BodyPoints body_points(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                       const BodyPointsOptions& options);

// Returns the numbers of at most `count` of the points, evenly spread: in each cell of a lattice the point nearest to
// its centre, in the order of the cells. The choice depends on the set of points, not on their order.
std::vector<std::uint32_t> spread_points(std::span<const Vec3d> points, std::size_t count);

// Returns the same for a lattice of this spacing, a length above the 2^-20th part of the points' extent.
std::vector<std::uint32_t> points_apart(std::span<const Vec3d> points, double spacing);

}  // namespace knead
