// The surfaces r = level of a field's region, as meshes to look at.
#pragma once

#include <optional>

#include "knead/field/field.h"
#include "knead/flow/segment.h"
#include "knead/math/box.h"
#include "knead/mesh/mesh.h"

namespace knead::render {

// The surface {r = level} at t = 0 with the field's centre at `center`. A plane is cut to about the box, or to the
// cylinder where there is one. Where the level of a ball, capsule or point set is not positive: a small ball at each
// centre or point, of the field's outer threshold's scale. Empty for a region of the caller's own.
Mesh region_surface(const Field& field, const Vec3d& center, double level, const Box& around,
                    const std::optional<Cylinder>& cylinder);

// The cylinder from the far end of the box up to the field's outer plane; the field's region is a half-space.
Mesh barrel_surface(const Cylinder& cylinder, const Field& field, const Box& around);

}  // namespace knead::render
