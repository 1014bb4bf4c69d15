// Private to shapes: the shapes made of regular grids, each with about the given number of vertices.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "knead/mesh.h"
#include "knead/vec.h"

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

// Private to shapes: the hand, the figure and the letter Y as signed distance bounds.

// A function that is negative inside, has Lipschitz constant 1 and is zero on a surface within the box.
struct Solid {
  double (*distance)(const Vec3d& p) = nullptr;
  Box box;
  double area = 0;  // of the surface, to about 5%
};

Solid hand_solid();
Solid figure_solid();
Solid letter_y_solid();

struct Ball {
  Vec3d center;
  double radius = 0;
};

// The convex hull of two balls; neither contains the other.
struct Cone {
  Ball a;
  Ball b;
};

// Returns the exact distance (Quilez, "Round cone").
inline double distance(const Cone& cone, const Vec3d& p) {
  const Vec3d ba = cone.b.center - cone.a.center;
  const double l2 = norm2(ba);
  const double rr = cone.a.radius - cone.b.radius;
  const double a2 = l2 - rr * rr;
  const Vec3d pa = p - cone.a.center;
  const double y = dot(pa, ba);
  const double z = y - l2;
  const double x2 = norm2(pa * l2 - ba * y);
  const double y2 = y * y * l2;
  const double z2 = z * z * l2;
  const double k = (rr < 0 ? -1.0 : 1.0) * rr * rr * x2;
  if ((z < 0 ? -1.0 : 1.0) * a2 * z2 > k) return std::sqrt(x2 + z2) / l2 - cone.b.radius;
  if ((y < 0 ? -1.0 : 1.0) * a2 * y2 < k) return std::sqrt(x2 + y2) / l2 - cone.a.radius;
  return (std::sqrt(x2 * a2 / l2) + y * rr) / l2 - cone.a.radius;
}

inline double distance(const Ball& ball, const Vec3d& p) { return norm(p - ball.center) - ball.radius; }

// Returns the smaller of two distances, rounded off if they differ by less than `width`. Its gradient is a mean of
// theirs.
inline double blend_min(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width * 0.25;
}

inline double blend_max(double a, double b, double width) { return -blend_min(-a, -b, width); }

}  // namespace knead::shapes_detail
