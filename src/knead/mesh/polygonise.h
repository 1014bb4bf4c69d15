// The surface {f = 0} of a scalar function as a closed triangle mesh.
#pragma once

#include <functional>

#include "knead/math/box.h"
#include "knead/mesh/mesh.h"

namespace knead {

// Negative inside, positive outside; a point with f = 0 or NaN counts as outside.
using ScalarFunction = std::function<double(const Vec3d&)>;

struct PolygoniseOptions {
  double cell = 0;       // edge of the cubic grid cells, > 0; at most 4096 of them along each side of the box
  double lipschitz = 0;  // |f(p) - f(q)| <= lipschitz |p - q|, e.g. 1 for a distance bound; 0: not known
  int relaxations = 8;   // rounds that even out the triangles and pull the vertices back onto the surface; 0 to 100
};

// The boundary of {f < 0} within the box, as triangles counter-clockwise seen from outside; without faces where f is
// nowhere negative at a grid corner. Where the surface leaves the box it is closed along the walls of the box.
//
// Always closed, and every edge has two triangles and every vertex one fan, whatever f is; two components never share a
// vertex. About 1.4 area / cell^2 vertices, each on the surface to about 1e-6 cell (without relaxations: about a tenth
// of a cell) where f is smooth on the scale of a cell. Features thinner than a cell may be lost. Deterministic: the
// same bits for the same values of f.
//
// Cost: without a Lipschitz constant f is evaluated at every grid corner; with one, whole blocks that cannot meet the
// surface cost one evaluation, about 5 for each vertex in all. Relaxing costs about 10 + 2 * relaxations for each
// vertex. Memory: about 200 bytes for each vertex, and 12 bytes for each corner in three layers of the grid.
//
// Throws InvalidInput for options out of range, for a box that is empty or not finite, and for a Lipschitz constant
// that is too small where this would leave a hole (elsewhere parts of the surface may be missing).
//
// Method: dual marching cubes (Nielson 2004): a vertex for each loop of crossed edges in a cell, a quadrilateral for
// each crossed edge; faces with four crossings are decided by the bilinear saddle, and the other way where both
// neighbours would pass the face twice with one loop, which is the one way in which the dual could fail to be a
// manifold.
Mesh polygonise(const ScalarFunction& f, const Box& box, const PolygoniseOptions& options);

}  // namespace knead
