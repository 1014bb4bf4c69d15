// A tree of boxes over triangles that answers nearest-point and ray queries.
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

// A point of the surface and the triangle that it lies in.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> barycentric{};  // weights of the corners: each from 0 to 1, sum 1
  Vec3d point;
  double distance = 0;
};

// Where a ray meets the surface.
struct RayHit {
  std::uint32_t triangle = 0;
  double t = 0;         // the hit is at origin + t direction
  bool leaves = false;  // the ray passes to the side that the triangle's normal points to: out of a solid
};

// A tree over any triangles, also degenerate ones. To search a point cloud, use triangles {i, i, i}: the number of a
// triangle is then the number of the point.
//
// Every answer equals that of a search through all triangles, to the bit: it depends on the triangles and positions,
// not on the tree. All coordinates must be finite and either 0 or between 1e-75 and 1e75 in magnitude.
//
// Cost: building takes about 0.3 us for each triangle, refitting 0.03 us. Near a surface of 20,000 triangles a ray
// query takes about 3 us and a nearest-point query 8 us; twice that for 200,000 (docs/decisions/0008). Memory: about
// 150 bytes for each triangle. Queries may run on many threads at once.
class SurfaceTree {
 public:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  // Builds the tree. It keeps copies of the triangles and positions. Throws InvalidInput where check_triangles() does.
  SurfaceTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions);

  // Moves the vertices; there must be as many positions as before. After large motions queries are slower than in a
  // newly built tree.
  void refit(std::span<const Vec3d> positions);

  // The same where only vertices that were in this box have moved: visits the triangles whose boxes meet it.
  void refit(std::span<const Vec3d> positions, const Box& moved);

  // Returns the point of the surface nearest to p; nothing if none is within max_distance. Of equally near triangles,
  // it returns the one with the lowest number.
  std::optional<SurfacePoint> closest(const Vec3d& p, double max_distance = kInfinity) const;

  // Returns the nearest points of the `count` nearest triangles within max_distance, one for each triangle; nearest
  // first, then by number. Time: linear in count for each triangle near p, so use it for small counts.
  std::vector<SurfacePoint> nearest(const Vec3d& p, std::size_t count, double max_distance = kInfinity) const;

  // Returns the first triangle that the ray meets at 0 <= t <= max_t; of several at the same t, the one with the lowest
  // number. The direction must not be zero and need not be a unit vector.
  std::optional<RayHit> first_hit(const Vec3d& origin, const Vec3d& direction, double max_t = kInfinity) const;

  // Returns every triangle that the ray meets at t >= 0, sorted by t, then by number. A ray exactly through an edge or
  // a vertex meets the same triangles as a ray just beside it. So a line through a closed surface enters as many
  // triangles as it leaves.
  std::vector<RayHit> hits(const Vec3d& origin, const Vec3d& direction) const;

 private:
  static constexpr std::size_t kLeafSize = 4;

  struct Entry {
    std::array<Vec3d, 3> corners;
    std::uint32_t triangle = 0;
  };

  std::span<const Entry> entries_of(std::size_t leaf) const;
  void fit_leaf(std::size_t leaf, std::span<const Vec3d> positions);
  void refit_below(std::size_t node, std::span<const Vec3d> positions, const Box& moved);
  // Calls visit(entry) for the entries within sqrt(limit2) of p, nearer boxes first. visit returns the new limit2.
  template <class Visit>
  void visit_near(const Vec3d& p, double limit2, Visit visit) const;
  // Calls visit(entry) for the entries whose boxes the ray meets before limit. visit returns the new limit.
  template <class Ray, class Visit>
  void visit_along(const Ray& ray, double limit, Visit visit) const;
  double limit2_of(double distance) const;

  std::vector<Triangle> triangles_;
  std::vector<Entry> entries_;  // in the order of the Morton curve
  std::size_t first_leaf_ = 1;  // a power of two
  std::vector<Box> nodes_;      // node i has the children 2 i and 2 i + 1; the root is 1
  double slack_ = 0;            // larger than any rounding error between a box and its contents
};

}  // namespace knead
