// Meshes of the surfaces r = level of a field's region, for pictures.
#pragma once

#include <optional>

#include "knead/field/field.h"
#include "knead/flow/segment.h"
#include "knead/math/box.h"
#include "knead/mesh/mesh.h"

namespace knead::render {

// The resolution of the surfaces.
struct SurfaceDetail {
  int cells = 64;            // of the grid for a point set's surface, along its longest side
  int relaxations = 8;       // of that surface (mesh/polygonise.h)
  int sides = 64;            // of round surfaces; small ones have half as many
  double straightening = 0;  // curves may deviate by this fraction of the level, to have fewer points

  friend bool operator==(const SurfaceDetail&, const SurfaceDetail&) = default;
};

// For pictures during a drag: some tens of milliseconds for a curve of 200 points, a few for other regions.
inline constexpr SurfaceDetail kLiveDetail{.cells = 24, .relaxations = 1, .sides = 32, .straightening = 0.05};

// Returns the surface {r = level} at t = 0 with the field's centre at `center`.
//   plane          cut to about the box, or to the barrel if there is one
//   ball, capsule, point set with level <= 0: a small ball at each centre or point, scaled by the outer threshold
//   handles        whose levels 0 and 1 are the sets themselves: some of their points, and the surface r = 1/4 or 3/4
//   function of the caller: empty
Mesh region_surface(const Field& field, const Vec3d& center, double level, const Box& around,
                    const std::optional<SegmentBarrel>& barrel, const SurfaceDetail& detail = {});

// Returns the barrel from the far end of the box to the field's outer plane. The field's region is a half-space.
Mesh barrel_surface(const SegmentBarrel& barrel, const Field& field, const Box& around,
                    const SurfaceDetail& detail = {});

}  // namespace knead::render
