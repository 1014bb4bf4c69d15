// Rays through the view's pixels, pixels of points, and the place of the shape under the pointer.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "knead/editor/render.h"
#include "knead/editor/workbench.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::studio {

struct Ray {
  Vec3d origin;
  Vec3d direction;  // a unit vector
};

// A camera and the size of the view that it fills, in pixels. Places are from the upper left corner, right and down.
struct Screen {
  render::Camera camera;
  int width = 1;
  int height = 1;
  double unit = 1;  // pixels for one point of the design: of what is drawn to be grabbed, and how near that must be
};

struct Pixel {
  double x = 0;
  double y = 0;
};

Ray ray_through(const Screen& screen, double x, double y);

// Returns the pixel of a point; nothing for a point behind the eye.
std::optional<Pixel> pixel_of(const Screen& screen, const Vec3d& p);

// Returns whether a closed line goes round a pixel, an odd number of times.
bool is_within(std::span<const Pixel> line, const Pixel& p);

// Returns the length that one pixel covers at the depth of a point.
double pixel_size(const Screen& screen, const Vec3d& p);

// Returns the same for one point of the design.
double point_size(const Screen& screen, const Vec3d& p);

// Returns the point at which the ray meets a plane; nothing if they are parallel or the plane is behind the eye.
std::optional<Vec3d> on_plane(const Ray& ray, const Vec3d& point, const Vec3d& normal);

// Returns the point of the line {point + s direction} that is nearest to the ray; nothing if they are parallel.
std::optional<Vec3d> on_line(const Ray& ray, const Vec3d& point, const Vec3d& direction);

// --- what the pointer hits
// --------------------------------------------------------------------------------------------

struct SurfaceHit {
  std::uint32_t triangle = 0;  // of a point cloud: the point
  std::array<double, 3> barycentric{};
  Vec3d point;
  Vec3d normal;  // a unit vector, out of the shape
};

// Returns the weights of the corners for a point in the plane of a triangle; those of the first corner if it has no
// area.
std::array<double, 3> barycentric_of(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

// Finds the point at which a ray hits a shape. Searches the shape in the state of the constructor or of the last
// follow(), and returns the hit in a later state with the same faces. Any thread may search while the picker does not
// change.
class Picker {
 public:
  // Takes about 0.2 us a triangle. `faces`: for each face whether it can be hit; empty: all can.
  explicit Picker(const ShapeState& state, const std::vector<bool>& faces = {});

  // Searches the shape in this state, which must fit, from now on. Time: proportional to the number of changed
  // vertices.
  void follow(const ShapeState& state);

  bool fits(const ShapeState& state) const { return state.mesh == mesh_; }

  // Returns the first surface along a ray, with its place in `now`, which must fit. Returns nothing if there is none,
  // as in point clouds.
  std::optional<SurfaceHit> pick(const Ray& ray, const ShapeState& now) const;

  // Returns the first point of a point cloud that a ray passes closely, at its depth on the ray, with a normal towards
  // the eye. Time: below 10 ns a point.
  std::optional<SurfaceHit> pick_point(const Ray& ray, const ShapeState& now) const;

  // Returns the corner of the hit's triangle that is nearest to it; of a point cloud the point.
  std::uint32_t vertex_of(const SurfaceHit& hit, const ShapeState& now) const;

  // Returns the point halfway between the ray's first entry into the shape and its exit.
  std::optional<Vec3d> middle(const Ray& ray, const ShapeState& now) const;

  // Returns the thickness of the shape under a hit, against its normal; nothing if there is no other side.
  std::optional<double> thickness(const SurfaceHit& hit, const ShapeState& now) const;

  // Returns the triangles that can be hit.
  const std::vector<Triangle>& triangles() const { return links_.triangles; }

 private:
  struct Links {
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> first;   // of each vertex, in around
    std::vector<std::uint32_t> around;  // the triangles at each vertex
  };

  static Links links_of(const ShapeState& state, const std::vector<bool>& faces);
  Vec3d searched(const SurfaceHit& hit) const;
  Vec3d vertex_normal(std::uint32_t vertex, const Snapshot& positions) const;

  std::shared_ptr<const Mesh> mesh_;
  Links links_;
  Snapshot followed_;
  std::vector<Vec3d> positions_;  // of it
  double point_distance_ = 0;     // how closely a ray passes a point of a cloud
  SurfaceTree tree_;
};

// Makes pickers for one shape after the other, and reuses a picker that has been released. All pickers of a pool are
// for the same choice of faces.
class PickerPool {
 public:
  std::shared_ptr<const Picker> make(const ShapeState& state, const std::vector<bool>& faces = {});

 private:
  struct Shelf {
    std::mutex mutex;
    std::unique_ptr<Picker> picker;
  };
  std::shared_ptr<Shelf> shelf_ = std::make_shared<Shelf>();
};

}  // namespace knead::studio
