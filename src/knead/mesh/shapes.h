// Procedural closed shapes.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "knead/mesh/mesh.h"

namespace knead {

// The kinds of procedural shapes.
enum class ShapeKind {
  sphere,    // radius 1, about the origin; an evenly subdivided icosahedron
  box,       // a bar along x: [-3, 3] x [-0.5, 0.5] x [-0.5, 0.5]
  cylinder,  // radius 0.5 about the z axis, z from -3 to 3, closed by disks
  torus,     // radii 1 and 0.3 about the z axis
  hand,      // a right hand: fingers along +y, palm towards +z, thumb on the side of +x; y from about -0.95 to 0.95
  crater,    // a block of ground: x and y from -5 to 5, bottom at z = -1.5, hilly surface near z = 0 with a crater
  knot,      // a trefoil on the torus of radii 2 and 1 about the z axis, tube of radius 0.45
  letter_y,  // x and y from -0.4 to 0.4, z from -0.1 to 0.1, flat in front and behind, edges rounded by 0.02
  figure,    // a person who stands with the arms apart, facing +z; y from about -0.99 to 0.99
};

// Returns the names, in the order of ShapeKind: "sphere", ..., "letter-y".
std::span<const std::string_view> shape_names();

// Returns the kind with this name. Throws InvalidInput for an unknown name.
ShapeKind shape_kind(std::string_view name);

// The numbers of vertices that make_shape() accepts for a kind, and its standard number.
struct ShapeCounts {
  std::size_t minimum;
  std::size_t standard;
  std::size_t maximum;
};
// Returns the numbers of vertices that a kind can have.
ShapeCounts shape_counts(ShapeKind kind);

// Returns a closed, manifold, connected triangle mesh of about `vertices` vertices (0: the standard number of the
// kind); triangles are counter-clockwise seen from outside. The number of vertices is within 10% of the given one; a
// sphere of fewer than 1000 has the nearest of 12, 42, 92, 162, 252, 362, 492, 642, 812 and 1002. The same arguments
// give the same bits. Throws InvalidInput for a number outside shape_counts(kind).
//
// Cost: about 0.1 us per vertex (letter-y 4 us, hand and figure 20 us); memory 70 bytes per vertex (letter-y, hand and
// figure 220).
Mesh make_shape(ShapeKind kind, std::size_t vertices = 0);

// A finger of the hand. On the tip's side of the plane through `base` orthogonal to `axis`, the finger is within
// `radius` of the line through base along axis and shorter than `length`. There, no other part of the hand is within
// radius + 0.02 of that line. So a cylinder of this radius and length contains this finger only.
struct Finger {
  std::string_view name;
  Vec3d base;
  Vec3d axis;  // unit vector, towards the tip
  double length = 0;
  double radius = 0;
};

// Returns the fingers: thumb, index, middle, ring, little.
std::span<const Finger> hand_fingers();

}  // namespace knead
