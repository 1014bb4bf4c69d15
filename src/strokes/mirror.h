// The images of strokes that act at the same time (Mirror in stroke.h). Internal to the library.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "knead/tools.h"

namespace knead {

// Returns all images but the stroke itself: in each plane, and in the planes one after the other.
std::vector<SymmetryImage> images_in(const Mirror& mirror);

// Returns a pose with the parts and pins of its images too, all as places: the vertices it names are looked up among
// the positions. What is its own image counts once; a pin in a plane stays in it. Throws InvalidInput for a vertex that
// is not there, and for a pose with `exact`.
PoseStroke with_images(const PoseStroke& stroke, const Mirror& mirror, std::span<const Vec3d> positions);

// Returns how many times as fast the sum of a stroke and its images moves points as one of them alone does at most, at
// some places about their tools; 1 for a segment that is no sum.
double speed_of_images(const Segment& segment);

// Returns the limit cylinders of the stroke and of its images, each once; none where it has none.
std::vector<StrokeCylinder> limit_cylinders_of(const Stroke& stroke, const Mirror& mirror);

}  // namespace knead

// Where a point meets a surface that moves.
namespace knead::tool_detail {

// Finds the closest points of a surface as it is at the moment. The surface outlives it.
class SurfaceFinder {
 public:
  explicit SurfaceFinder(const LiveSurface& surface);

  // The closest point of the surface and the unit normal there: of triangles, interpolated from the angle-weighted
  // normals of the vertices (Thurmer and Wuthrich 1998); of a point cloud, the weighted mean of the nearest points and
  // normals. Nothing where there is no such normal.
  std::optional<PaintSample> closest(const Vec3d& p) const;

  // Follows a motion of the surface in which only vertices within `radius` of p have moved.
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

}  // namespace knead::tool_detail
