// The closest point of a surface that moves, and its normal.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/mesh.h"

namespace knead::detail {

// Finds the closest points on the current surface. The surface must outlive it.
class SurfaceFinder {
 public:
  explicit SurfaceFinder(const LiveSurface& surface);

  // Returns the closest point of the surface and the unit normal there: of triangles, interpolated from the
  // angle-weighted normals of the vertices (Thurmer and Wuthrich 1998); of a point cloud, the weighted mean of the
  // nearest points and normals. Returns nothing if there is no such normal.
  std::optional<PaintSample> closest(const Vec3d& p) const;

  // Updates the finder after a motion of the surface in which only vertices within `radius` of p have moved.
  void follow(const Vec3d& p, double radius);

 private:
  std::optional<PaintSample> closest_on_triangles(const Vec3d& p) const;
  std::optional<PaintSample> closest_in_cloud(const Vec3d& p) const;
  Vec3d vertex_normal(std::uint32_t vertex) const;

  const LiveSurface& surface_;
  SurfaceTree tree_;                   // of a point cloud, its points
  std::vector<std::uint32_t> first_;   // of each vertex, in around_
  std::vector<std::uint32_t> around_;  // the triangles at each vertex
};

}  // namespace knead::detail
