// Which vertices of a deformed shape the stroke of a barrel had moved: what its inverse needs to know.
#pragma once

#include <span>
#include <vector>

#include "knead/mesh/triangulate.h"
#include "knead/tool/barrel.h"

namespace knead {

// For a shape after the stroke, `deformed`, and its vertices as the stroke's inverse without the barrel takes them
// back, `taken_back`: whether each was moved, so that taken_back is where it came from, or never was. A vertex that
// comes from outside the barrel was not; one that lies inside it, where a resting point would have been moved, was.
// Where both could be (the barrel reaches beyond a bent finger's tip, and its image may cover the thumb) the surface
// decides: no triangle crossed the barrel where anything moved, so neighbours that move are of one kind. Distances are
// compared with a slack, a length above the error of taken_back. Vertices of no triangle, and pieces that could all be
// either, are taken to have moved if they come from within the radius. Time: linear.
std::vector<bool> barrel_members(const Barrel& barrel, std::span<const Vec3d> deformed,
                                 std::span<const Vec3d> taken_back, std::span<const Triangle> triangles, double slack);

}  // namespace knead
