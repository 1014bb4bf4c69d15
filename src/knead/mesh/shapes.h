// Closed shapes made by computation, without data files.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "knead/mesh/mesh.h"

namespace knead {

enum class ShapeKind {
  sphere,    // radius 1, about the origin; an icosahedron, subdivided evenly
  box,       // a bar along x: [-3, 3] x [-0.5, 0.5] x [-0.5, 0.5]
  cylinder,  // radius 0.5 about the z axis, z from -3 to 3, closed by discs
  torus,     // radii 1 and 0.3 about the z axis
  hand,      // a right hand: fingers along +y, palm towards +z, thumb on the side of +x; y from about -0.95 to 0.95
  crater,    // a block of ground: x and y from -5 to 5, bottom at z = -1.5, rolling surface about z = 0 with a crater
  knot,      // a trefoil on the torus of radii 2 and 1 about the z axis, tube of radius 0.45
  letter_y,  // x and y from -0.4 to 0.4, z from -0.1 to 0.1, flat in front and behind, edges rounded by 0.02
};

// The names, in the order of ShapeKind: "sphere", ..., "letter-y".
std::span<const std::string_view> shape_names();

// The kind of that name. Throws InvalidInput for any other name.
ShapeKind shape_kind(std::string_view name);

// The numbers of vertices that a kind can be asked for: from minimum to maximum.
struct ShapeCounts {
  std::size_t minimum;
  std::size_t standard;
  std::size_t maximum;
};
ShapeCounts shape_counts(ShapeKind kind);

// A shape of about `vertices` vertices (0: the kind's standard number): closed, manifold, in one component, of
// triangles counter-clockwise seen from outside. The number of vertices comes within 10% of the wish, but a sphere of
// fewer than 1000 has the nearest of 12, 42, 92, 162, 252, 362, 492, 642, 812 and 1002. Deterministic.
//
// Cost: about 0.1 us per vertex, letter-y 4 us, hand 20 us; memory 70 bytes per vertex, letter-y and hand 220.
// Throws InvalidInput for a number outside shape_counts(kind).
Mesh make_shape(ShapeKind kind, std::size_t vertices = 0);

// Where a finger of the hand can be gripped: beyond the plane through `base` across `axis`, the finger lies within
// `radius` of the line through base along axis and ends before `length`; no other part of the hand comes within
// radius + 0.02 of that line for heights between 0 and length.
struct Finger {
  std::string_view name;
  Vec3d base;
  Vec3d axis;  // unit, towards the tip
  double length = 0;
  double radius = 0;
};

// thumb, index, middle, ring, little.
std::span<const Finger> hand_fingers();

}  // namespace knead
