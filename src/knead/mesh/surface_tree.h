// Nearest points and rays: a tree of boxes over triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "knead/math/box.h"
#include "knead/math/vec3.h"
#include "knead/mesh/triangulate.h"

namespace knead {

struct SurfacePoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> barycentric{};  // of the triangle's corners: each from 0 to 1, their sum 1
  Vec3d point;
  double distance = 0;
};

struct RayHit {
  std::uint32_t triangle = 0;
  double t = 0;         // at origin + t direction
  bool leaves = false;  // the direction points to the side of the triangle's normal: out of a solid
};

// A tree over triangles: any, also degenerate ones. A point cloud is searched as triangles {i, i, i}, for which a
// triangle's number is the point's.
//
// The answers are those of a search through every triangle, to the bit: they depend on the triangles and positions
// only, not on the tree. Positions, and what is asked, are finite; coordinates that are not 0 lie between 1e-75 and
// 1e75 in magnitude.
//
// Built in about 0.3 us a triangle and refitted in about 0.03. Among 20,000 triangles a query near the surface takes
// some 3 us for a ray and 8 us for a nearest point, twice that among 200,000 (docs/decisions/0008).
// Memory: about 150 bytes a triangle. Safe to ask from many threads at once.
class SurfaceTree {
 public:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  // Keeps copies of both.
  SurfaceTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions);

  // The same triangles with moved vertices, as many as before. Where they have moved far the tree gets slower; a new
  // one is then better.
  void refit(std::span<const Vec3d> positions);

  // The point of the surface nearest to p; of several equally near triangles the one of the lowest number. Nothing
  // where there is none within max_distance.
  std::optional<SurfacePoint> closest(const Vec3d& p, double max_distance = kInfinity) const;

  // The nearest points of up to `count` triangles, each triangle's own; nearest first, then by number. Time: linear in
  // count for each triangle near p, so for few.
  std::vector<SurfacePoint> nearest(const Vec3d& p, std::size_t count, double max_distance = kInfinity) const;

  // The first triangle that the ray meets at 0 <= t <= max_t, of several at the same t the one of the lowest number.
  // The direction is not zero; it need not be a unit vector.
  std::optional<RayHit> first_hit(const Vec3d& origin, const Vec3d& direction, double max_t = kInfinity) const;

  // Every triangle that the ray meets at t >= 0, in order of t, then number. A ray that passes exactly through an edge
  // or a vertex meets as many triangles as one beside it does: so along the whole line through a closed surface as many
  // triangles are entered as left.
  std::vector<RayHit> hits(const Vec3d& origin, const Vec3d& direction) const;

 private:
  static constexpr std::size_t kLeafSize = 4;

  struct Entry {
    std::array<Vec3d, 3> corners;
    std::uint32_t triangle = 0;
  };

  std::span<const Entry> entries_of(std::size_t leaf) const;
  // Calls visit(entry) for those within sqrt(limit2) of p, nearer boxes first; visit returns the new limit2.
  template <class Visit>
  void visit_near(const Vec3d& p, double limit2, Visit visit) const;
  // Calls visit(entry) for those whose boxes the ray meets before limit; visit returns the new limit.
  template <class Ray, class Visit>
  void visit_along(const Ray& ray, double limit, Visit visit) const;
  double limit2_of(double distance) const;

  std::vector<Triangle> triangles_;
  std::vector<Entry> entries_;  // in the order of the Morton curve
  std::size_t first_leaf_ = 1;  // a power of two
  std::vector<Box> nodes_;      // node i has the children 2 i and 2 i + 1; the root is 1
  double slack_ = 0;            // more than any rounding between a box and what is in it
};

}  // namespace knead
