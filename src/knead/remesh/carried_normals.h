// Keeps the authored normals of a patch correct. Internal to the remesh room.
#pragma once

#include "knead/remesh/patch.h"

namespace knead::remesh_detail {

// Transforms the attribute "normal" (3 components) of vertices or corners by the deformation from `before` to `after`
// of the surface (see transport_normals), also for vertices that splits have made.
void turn_normals(const Mesh& mesh, Surface& surface);

// Scales the normals of the surface to length 1. Lengths that are 1 to the rounding of float keep their bits.
void normalise_normals(const Mesh& mesh, Surface& surface);

}  // namespace knead::remesh_detail
