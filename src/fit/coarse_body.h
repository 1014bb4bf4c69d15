// A few hundred points of a shape that move between two poses as rigidly as possible. Internal to the fit module.
//
// The points lie on the surface. Their neighbours are near along the mesh's edges, or straight through the body; so
// limbs that touch are not connected. The energy is that of as-rigid-as-possible surfaces (Sorkine and Alexa 2007),
// without volume and collisions: its results only guide a flow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "fit/fit_align.h"
#include "fit/surface_matches.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/sparse_cholesky.h"

namespace knead::detail {

// A point of the shape and its target.
struct Anchor {
  Vec3d from;
  Vec3d to;
  double weight = 1;         // 1: nearly exact; above 0
  bool is_doubtful = false;  // loses weight if it disagrees with the others
};

// Returns the position at a time on a path whose points are at evenly spaced times from 0 to 1; the length of the path.
Vec3d place_on(const std::vector<Vec3d>& path, double time);
double length_of_path(const std::vector<Vec3d>& path);

// Returns for each vertex the index in `chosen` of the vertex nearest along edges; the greatest number if there is
// none.
std::vector<std::uint32_t> nearest_along_edges(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                               const std::vector<std::uint32_t>& chosen);

// The graph of points and its pose.
class CoarseBody {
 public:
  // Takes about `count` evenly spread vertices. There is at least one position. A cloud has no triangles.
  CoarseBody(std::span<const Vec3d> positions, std::span<const Triangle> triangles, std::size_t count);

  // Finds the pose in which the anchors are at their targets. Throws Cancelled. Time: about 0.3 s.
  void pose(std::span<const Anchor> anchors, const Progress* progress);

  // Returns the path of each anchor at `pieces` + 1 evenly spaced times from 0 to 1, from `from` to `to`: limbs turn
  // about their joints.
  std::vector<std::vector<Vec3d>> paths(std::span<const Anchor> anchors, std::size_t pieces) const;

  // Returns points of the shape and their normals in the pose.
  std::vector<SurfaceSample> posed(std::span<const SurfaceSample> samples) const;

  // Returns an anchor for each node, with its position in the pose as target.
  std::vector<Anchor> node_anchors() const;

  const std::vector<Vec3d>& nodes() const { return rest_; }
  // Returns the lengths of the shortest paths along edges from a node to all of them.
  std::vector<double> distances_from(std::uint32_t node) const;

 private:
  struct Edge {
    std::uint32_t to = 0;
    double weight = 1;
  };
  struct Held {
    std::uint32_t node = 0;
    Vec3d offset;
    double weight = 0;
  };

  void connect_along_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                             const std::vector<std::uint32_t>& chosen);
  void connect_through(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                       const std::vector<std::uint32_t>& chosen, const std::vector<std::uint32_t>& node_of);
  void connect_nearest(std::size_t count);
  void connect_pieces();
  void add_edge(std::uint32_t a, std::uint32_t b, double weight);
  void order();

  std::uint32_t nearest_node(const Vec3d& p) const;
  std::uint32_t calmest_node() const;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> steps_from(std::uint32_t root) const;
  std::vector<Held> held_by(std::span<const Anchor> anchors) const;
  SymmetricMatrix matrix_with(std::span<const Held> held) const;
  void iterate(const SparseCholesky& factor, std::span<const Held> held, std::span<const Vec3d> to);
  void find_turns();
  std::vector<Vec3d> right_side(const std::vector<Quaternion>& turns) const;

  double unit_ = 0;  // of the anchors' weights
  std::vector<Vec3d> rest_;
  std::vector<std::vector<Edge>> edges_;
  std::vector<Vec3d> posed_;  // the nodes in the pose
  std::vector<Quaternion> turns_;
};

}  // namespace knead::detail
