// A mesh as the GPU is given it while it deforms: what changes when vertices move, and no more.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/box.h"
#include "knead/mesh/mesh.h"
#include "knead/render/live_normals.h"
#include "knead/render/live_rings.h"
#include "knead/render/live_view.h"
#include "knead/render/view.h"

namespace knead::render {

// Drawn vertices are one per vertex and smooth group of faces, as in make_surface, in the order of the mesh's vertices.
// The groups, the triangles and the edges are those of the mesh that it was made of; only places change. Normals are
// those of set_ring_normals; the same bits for any number of threads, and
// for a vertex that moved at once or in many steps.
class LiveMesh {
 public:
  LiveMesh() = default;

  // crease_angle: as for make_surface. The mesh need not outlive the call. Cost: about 1 us per vertex.
  LiveMesh(const Mesh& mesh, const Placement& placement, double crease_angle);

  // Takes over the places of the vertices in `changed`; positions has all vertices of the mesh. Returns the ranges of
  // drawn vertices that are new: those that moved and the one ring around them; ascending, apart, at most a few
  // hundred, with short gaps closed. Throws InvalidInput for another number of positions or a range beyond it.
  std::vector<VertexRange> move(std::span<const Vec3d> positions, std::span<const VertexRange> changed, int threads);

  const std::vector<LiveVertex>& vertices() const { return vertices_; }
  std::span<const std::uint32_t> triangles() const { return triangles_; }  // three drawn vertices each
  std::span<const std::uint32_t> edges() const { return edges_; }          // two drawn vertices each; of the polygons
  double mean_edge() const { return mean_edge_; }                          // when it was made; renderer units
  const Rings& rings() const { return rings_; }                            // empty in a cloud
  bool is_cloud() const { return triangles_.empty(); }
  bool is_solid() const { return solid_; }  // when it was made: closed, and its faces turned outwards
  Box box() const;                          // of the finite vertices, renderer units

  // Calls visit(v, d) for every drawn vertex d of every vertex v in the range.
  template <class Visit>
  void for_each_drawn(const VertexRange& range, Visit visit) const {
    for (std::uint32_t v = range.begin; v < range.end; ++v) {
      for (std::uint32_t d = drawn_begin_[v]; d < drawn_begin_[v + 1]; ++d) visit(v, d);
    }
  }
  std::size_t vertex_count() const { return points_.size(); }

 private:
  void place(std::span<const Vec3d> positions, const VertexRange& range);
  void shade(const VertexRange& range);
  void measure(const std::vector<std::uint8_t>& blocks, int threads);
  void mark(const VertexRange& range);
  std::vector<VertexRange> marked_runs();

  Placement placement_;
  std::vector<Vec3f> points_;                  // per vertex of the mesh
  std::vector<Box> boxes_;                     // of every block of kBlock vertices
  std::vector<std::uint32_t> drawn_begin_{0};  // the drawn vertices of vertex v: drawn_begin_[v] to drawn_begin_[v + 1]
  std::vector<LiveVertex> vertices_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> edges_;
  Rings rings_;                      // empty in a cloud
  std::vector<std::uint8_t> marks_;  // per vertex, zero between calls
  double mean_edge_ = 0;
  bool solid_ = false;
};

}  // namespace knead::render
