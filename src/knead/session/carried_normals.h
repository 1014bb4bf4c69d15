// Normals carried by the flow. Internal to the session room.
#pragma once

#include <span>
#include <vector>

#include "knead/session/deformed_shape.h"

namespace knead::session_detail {

// Returns whether a normal is neither zero nor too long to be normalised.
bool has_direction(const Vec3d& normal);

// Places four points around every point whose normal has a direction; as many normals as positions. `reach`: a length
// above 0. The error of a turned normal falls with its square until rounding takes over.
CarriedNormals carry_normals(std::span<const Vec3d> positions, std::vector<Vec3d> normals, double reach);

// Returns the normals as the points show them now; lengths are kept. A normal keeps its bits if its points did not
// move, or were torn apart (at the wall of a barrel).
std::vector<Vec3d> turned_normals(const CarriedNormals& carried);

// The same of one vertex.
Vec3d turned_normal(const CarriedNormals& carried, std::uint32_t vertex);

}  // namespace knead::session_detail
