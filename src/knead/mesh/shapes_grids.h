// Private to shapes: the shapes made of regular grids, each with about the given number of vertices.
#pragma once

#include <cstddef>

#include "knead/mesh/mesh.h"

namespace knead::shapes_detail {

Mesh make_sphere(std::size_t vertices);
Mesh make_box(std::size_t vertices);
Mesh make_crater(std::size_t vertices);
Mesh make_cylinder(std::size_t vertices);
Mesh make_torus(std::size_t vertices);
Mesh make_knot(std::size_t vertices);

// Returns the surface of [0, nx] x [0, ny] x [0, nz] as unit squares, each split into two triangles along alternating
// diagonals. Vertices have integer coordinates.
Mesh box_surface(std::size_t nx, std::size_t ny, std::size_t nz);

void add_triangle(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c);

// Adds the quadrilateral a, b, c, d as two triangles, split along the shorter diagonal.
void add_quad(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c, std::size_t d);

}  // namespace knead::shapes_detail
