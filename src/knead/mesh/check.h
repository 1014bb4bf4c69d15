// Checks of meshes whose positions are given apart from them. Internal to the mesh room.
#pragma once

#include <span>

#include "knead/mesh/mesh.h"

namespace knead {

// Throws InvalidInput, with the number of the first element at fault, unless the faces of the mesh are sound and there
// is one finite position for each vertex. Does not look at attributes. Time: a pass over corners and positions.
void require_sound(const Mesh& mesh, std::span<const Vec3d> positions);

// The same, but the positions may be any numbers.
void require_faces(const Mesh& mesh, std::span<const Vec3d> positions);

}  // namespace knead
