// Normals of points without faces, carried by the flow's Jacobian.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/vec3.h"

namespace knead {

// Four points around each point that has a normal, in the plane across it: where the flow takes them says how it turns
// that plane. The image of a surface's normal under a map with the Jacobian J is J t1 x J t2 for tangents t1 and t2.
struct NormalCompanions {
  std::vector<std::uint32_t> vertex;  // whose companions points[4 k] to points[4 k + 3] are
  std::vector<Vec3d> points;          // p + a, p - a, p + b, p - b
  double reach = 0;                   // length of a and b
};

// Whether a normal is neither zero nor beyond what can be normalised.
bool has_direction(const Vec3d& normal);

// The companions of the points whose normals have a direction, as many normals as positions. `reach` is a length > 0:
// the error of a turned normal falls with its square until rounding takes over.
NormalCompanions companions_of(std::span<const Vec3d> positions, std::span<const Vec3d> normals, double reach);

// The normals after the companions have moved to `moved`, in the order of their points; lengths are kept. A normal
// whose companions did not move keeps its bits, and so does one whose companions were torn apart (at the wall of a
// cylinder).
std::vector<Vec3d> carried_normals(const NormalCompanions& companions, std::span<const Vec3d> moved,
                                   std::span<const Vec3d> normals);

}  // namespace knead
