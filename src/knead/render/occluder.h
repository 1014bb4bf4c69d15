// What casts shadows: the shapes, in a coarser copy where they are finer than a shadow map.
#pragma once

#include <array>
#include <vector>

#include "knead/render/surface.h"

namespace knead::render {

struct Occluder {
  std::vector<Vec3f> positions;
  std::vector<std::uint32_t> indices;  // three per triangle
  std::vector<Vec3f> points;           // of point clouds
  Vec3d center;                        // of a ball that holds everything
  double radius = 0;                   // 0: nothing casts a shadow
  double ground = 0;                   // the lowest dot(up, p)
};

// cell: vertices that lie in one cell of this size become one where there are more than max_triangles triangles, as in
// Rossignac and Borrel, "Multi-resolution 3D approximations for rendering complex scenes" (1993). Deterministic.
Occluder make_occluder(const std::vector<DrawSurface>& surfaces, const Vec3d& up, double cell,
                       std::size_t max_triangles);

// Removes what lies beyond the plane: dot(plane xyz, p) > plane w. Triangles across it are cut.
void clip_occluder(Occluder& occluder, const std::array<float, 4>& plane);

}  // namespace knead::render
