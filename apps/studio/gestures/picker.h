// From the view's pixels into the scene and back.
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
};

struct Pixel {
  double x = 0;
  double y = 0;
};

Ray ray_through(const Screen& screen, double x, double y);

// Where a point is seen; nothing for one behind the eye.
std::optional<Pixel> pixel_of(const Screen& screen, const Vec3d& p);

// Returns whether a closed line goes round a pixel, an odd number of times.
bool is_within(std::span<const Pixel> line, const Pixel& p);

// The length that one pixel covers at the depth of a point.
double pixel_size(const Screen& screen, const Vec3d& p);

// Where the ray meets a plane; nothing where they are parallel or the plane is behind.
std::optional<Vec3d> on_plane(const Ray& ray, const Vec3d& point, const Vec3d& normal);

// The point of the line {point + s direction} that is nearest to the ray; nothing where they are parallel.
std::optional<Vec3d> on_line(const Ray& ray, const Vec3d& point, const Vec3d& direction);

// --- what the pointer hits
// --------------------------------------------------------------------------------------------

struct SurfaceHit {
  std::uint32_t triangle = 0;
  std::array<double, 3> barycentric{};
  Vec3d point;
  Vec3d normal;  // a unit vector, out of the shape
};

// Returns the weights of the corners for a point in the plane of a triangle; those of the first corner if it has no
// area.
std::array<double, 3> barycentric_of(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

// Finds where a ray hits a shape. Searches the shape as it was when the picker was made or last followed a state, and
// returns the hit as it lies in a later state with the same faces. Any thread may search while the picker does not
// change.
class Picker {
 public:
  // Takes about 0.2 us a triangle. `faces`: for each face whether it can be hit; empty: all can.
  explicit Picker(const ShapeState& state, const std::vector<bool>& faces = {});

  // From now on searches the shape as it is in this state, which fits. Time: proportional to what differs from before.
  void follow(const ShapeState& state);

  bool fits(const ShapeState& state) const { return state.mesh == mesh_; }

  // Returns the first surface along a ray, as it lies in `now`, which fits. Nothing if there is none, as in point
  // clouds.
  std::optional<SurfaceHit> pick(const Ray& ray, const ShapeState& now) const;

  // Returns the point halfway between where the ray enters the shape and where it leaves it again.
  std::optional<Vec3d> middle(const Ray& ray, const ShapeState& now) const;

  // Returns how thick the shape is under a hit, against its normal; nothing where no surface is found there.
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
  SurfaceTree tree_;
};

// Makes pickers for one shape after the other, and uses one again when nobody holds it any more. A pool makes all of
// them for the same choice of faces.
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
