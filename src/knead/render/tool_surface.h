// The surfaces r = level of a field's region, as meshes to look at.
#pragma once

#include <optional>

#include "knead/field/field.h"
#include "knead/flow/segment.h"
#include "knead/math/box.h"
#include "knead/mesh/mesh.h"

namespace knead::render {

// How finely surfaces are made.
struct SurfaceDetail {
  int cells = 64;            // of the grid in which a point set's surface is found, along its longest side
  int relaxations = 8;       // of that surface (mesh/polygonise.h)
  int sides = 64;            // of round things; small ones have half as many
  double straightening = 0;  // curves may leave their way by this part of the level, for fewer points

  friend bool operator==(const SurfaceDetail&, const SurfaceDetail&) = default;
};

// For pictures while something is dragged: some tens of milliseconds for a curve of 200 points, a few for the others.
inline constexpr SurfaceDetail kLiveDetail{.cells = 24, .relaxations = 1, .sides = 32, .straightening = 0.05};

// The surface {r = level} at t = 0 with the field's centre at `center`. A plane is cut to about the box, or to the
// cylinder where there is one. Where the level of a ball, capsule or point set is not positive: a small ball at each
// centre or point, of the field's outer threshold's scale. Of marked regions, whose levels 0 and 1 are the sets
// themselves: some of their points, and the surface r = 1/4 or 3/4 about them. Empty for a region of the caller's own.
Mesh region_surface(const Field& field, const Vec3d& center, double level, const Box& around,
                    const std::optional<Cylinder>& cylinder, const SurfaceDetail& detail = {});

// The cylinder from the far end of the box up to the field's outer plane; the field's region is a half-space.
Mesh barrel_surface(const Cylinder& cylinder, const Field& field, const Box& around, const SurfaceDetail& detail = {});

}  // namespace knead::render
