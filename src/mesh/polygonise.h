// Makes a closed triangle mesh of the surface {f = 0} of a scalar function.
#pragma once

#include <functional>

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
// relaxations: to a tenth of a cell). Features thinner than a cell may be lost. The same values of f give the same
// bits.
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

// A shape that is given by a bound of the distance: negative inside, with Lipschitz constant 1, and zero on a surface
// within the box.
struct Solid {
  double (*distance)(const Vec3d& p) = nullptr;
  Box box;
  double area = 0;  // of the surface, to about 5%
};

// Return shapes of make_shape() (figures.cpp).
Solid hand_solid();
Solid figure_solid();
Solid letter_y_solid();

}  // namespace knead
