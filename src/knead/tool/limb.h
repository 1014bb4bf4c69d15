// Finding the limb of a shape that a person points at: a finger, an arm, a leg.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/vec3.h"
#include "knead/mesh/triangulate.h"

namespace knead {

// A limb of a shape, such as a finger or an arm, and its joint.
struct Limb {
  std::vector<std::uint32_t> vertices;  // beyond the joint, in ascending order
  std::vector<std::uint32_t> bending;   // what is next to it, and bends with it
  std::vector<std::uint32_t> beside;    // limbs that run along it, too near to hold while it bends: they follow it
  std::vector<std::uint32_t> body;      // what can hold while the limb bends: all else that is joined to it
  Vec3d joint;                          // the middle of the cross-section where the limb begins
  Vec3d direction{0, 0, 1};             // along the limb, from the joint: a unit vector
  double girth = 0;                     // round the joint
  bool has_neck = false;                // the shape widens behind the joint; else the limb begins at the given vertex
};

// Returns the limb on which a vertex lies, from the first place behind the vertex where the shape widens: where the
// girth grows by a third or more within one thickness of the limb. A cross-section is all that is equally far from the
// limb's tip, along the surface; the tip is where the surface rises to from the vertex, away from the core, which is
// about equally far from the ends of the shape. What no triangle joins to the vertex is not of the limb, which has no
// vertices where the given one has no triangle. Time: about 2 us a vertex, and as much for each limb beside it. Throws
// std::out_of_range for a vertex that there is not.
Limb find_limb(std::span<const Vec3d> positions, std::span<const Triangle> triangles, std::uint32_t vertex);

}  // namespace knead
