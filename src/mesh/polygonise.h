// Makes a closed triangle mesh of the surface {f = 0} of a scalar function.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

// A function that is negative inside and positive outside. A point with f = 0 or NaN counts as outside.
using ScalarFunction = std::function<double(const Vec3d&)>;

// Where and how finely a surface is sampled.
struct PolygoniseOptions {
  double cell = 0;       // edge length of the cubic grid cells, > 0; at most 4096 cells along each side of the box
  double lipschitz = 0;  // |f(p) - f(q)| <= lipschitz |p - q|, e.g. 1 for a distance; 0: unknown
  int relaxations = 8;   // rounds of smoothing; each ends with the vertices back on the surface; 0 to 100
};

// Returns the boundary of {f < 0} within the box as triangles, counter-clockwise seen from outside. The mesh has no
// faces if f is not negative at any grid corner. A surface that leaves the box is closed along the walls of the box.
//
// The mesh is closed and manifold for every f: each edge has two triangles, each vertex one fan. It has about 1.4 area
// / cell^2 vertices. If f is smooth on the scale of a cell, each vertex is on the surface to about 1e-6 cell (without
// relaxations: a tenth of a cell). Features thinner than a cell may be lost. The same values of f give the same bits.
//
// Cost: without a Lipschitz constant, f is evaluated at every grid corner. With one, a block of cells that cannot
// contain the surface costs one evaluation; in all about 5 evaluations for each vertex. Relaxing adds about 10 + 2 *
// relaxations for each vertex. Memory: about 200 bytes for each vertex, and 12 bytes for each corner in three layers of
// the grid.
//
// Throws InvalidInput for options out of range, for a box that is empty or not finite, and if a Lipschitz constant that
// is too small would leave a hole. (Such a constant may also lose parts of the surface without an error.)
//
// Method: dual marching cubes (Nielson 2004). Each loop of crossed edges in a cell becomes a vertex, each crossed edge
// of the grid a quadrilateral. The sign of the bilinear saddle decides how a cell face with four crossings is
// connected. If both neighbours would then pass the face twice with one loop, the opposite connection is used: only
// this case could make the dual surface non-manifold.
Mesh polygonise(const ScalarFunction& f, const Box& box, const PolygoniseOptions& options);

}  // namespace knead

// Private to polygonise: finds the cells of a regular grid that contain the surface {f = 0}.
namespace knead::polygonise_detail {

// A grid of cubic cells. Cell (x, y, z) has 0 <= x < cells[0] and so on; cell (0, 0, 0) begins at `origin`.
struct Grid {
  Vec3d origin;
  double cell = 0;
  std::array<std::uint32_t, 3> cells{};

  Vec3d at(double x, double y, double z) const { return origin + Vec3d{x, y, z} * cell; }
};

// Returns grid coordinates as one number that sorts by z, then y, then x; 20 bits each. grid_place() is the inverse.
inline std::uint64_t grid_key(std::uint64_t x, std::uint64_t y, std::uint64_t z) { return (z << 40) | (y << 20) | x; }
inline std::array<std::uint32_t, 3> grid_place(std::uint64_t key) {
  constexpr std::uint64_t kMask = (1U << 20) - 1;
  return {static_cast<std::uint32_t>(key & kMask), static_cast<std::uint32_t>((key >> 20) & kMask),
          static_cast<std::uint32_t>(key >> 40)};
}

// A cell with corners both inside and outside. Corner c has the offset (c & 1, (c >> 1) & 1, c >> 2).
struct SurfaceCell {
  std::uint64_t key = 0;
  std::array<double, 8> values{};

  bool inside(int corner) const { return values[corner] < 0; }
};

// Returns every such cell, by increasing key. For lipschitz see PolygoniseOptions.
std::vector<SurfaceCell> surface_cells(const ScalarFunction& f, const Grid& grid, double lipschitz);

// Private to polygonise: makes the quadrilateral surface that is dual to marching cubes.

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

// Private to polygonise: smooths a surface and keeps it on {f = 0}.

// Moves every vertex onto {f = 0}, then `rounds` times towards the mean of its neighbours in the tangent plane and back
// onto {f = 0}. Does nothing for rounds = 0. A vertex moves at most one cell in all, and never where |f| would grow. So
// a function that is rough on the scale of a cell hardly changes the surface.
void relax(QuadSurface& surface, const ScalarFunction& f, double cell, int rounds);

// Returns triangles: each quadrilateral is split along the diagonal that gives the larger smallest angle.
Mesh split_quads(const QuadSurface& surface);

}  // namespace knead::polygonise_detail
