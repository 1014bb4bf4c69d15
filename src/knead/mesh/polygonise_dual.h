// Private to polygonise: the quadrilateral surface dual to marching cubes.
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

// One vertex, the mean of its crossings, for each loop of crossed edges in a cell; one quadrilateral for each crossed
// edge of the grid. Manifold, and so are its triangles however each quadrilateral is split: the four cells about an
// edge of the grid are distinct, two of them that face each other across it share no other edge, and no two loops of
// neighbouring cells meet in two segments of one face (see separate_doubled_faces).
// The cells are those of surface_cells; no crossed edge may lie on the wall of the grid.
// Throws InvalidInput where a cell about a crossed edge is missing.
QuadSurface dual_surface(std::span<const SurfaceCell> cells, const Grid& grid);

}  // namespace knead::polygonise_detail
