// Authored normals in a patch. Internal to the remesh room.
#pragma once

#include "knead/remesh/patch.h"

namespace knead::remesh_detail {

// Turns the attribute "normal" (3) of vertices or corners by the deformation of the patch, whose vertices stand at
// `before` and `after` (transport_normals); also those that splits interpolated, which get the mean length again.
void turn_normals(const Mesh& mesh, Surface& surface);

// Gives interpolated normals the length 1, where the mesh's normals have that.
void normalise_normals(const Mesh& mesh, Surface& surface);

}  // namespace knead::remesh_detail
