// Private to polygonise: makes the quadrilateral surface that is dual to marching cubes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh/polygonise_cells.h"

namespace knead::polygonise_detail {

using Quad = std::array<std::uint32_t, 4>;  // counter-clockwise seen from outside

struct QuadSurface {
  std::vector<Vec3d> positions;
  std::vector<Quad> quads;
};

// Returns a surface with a vertex for each loop of crossed edges in a cell, at the mean of its crossings, and a
// quadrilateral for each crossed edge of the grid. `cells` must come from surface_cells(), and no crossed edge may lie
// on the wall of the grid. Throws InvalidInput if a cell at a crossed edge is missing.
//
// The surface is manifold, and remains so when each quadrilateral is split along any diagonal: the four cells at a grid
// edge are distinct, opposite ones share no other edge, and no two loops of neighbouring cells meet in two segments of
// one face (see separate_doubled_faces).
QuadSurface dual_surface(std::span<const SurfaceCell> cells, const Grid& grid);

}  // namespace knead::polygonise_detail
