#include <algorithm>
#include <array>

#include "knead/remesh/relax.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

namespace {

// Lists the corners of the triangles at each vertex.
void list_corners(std::span<const Triangle> triangles, std::size_t vertices, RelaxTopology& topology) {
  topology.corner_begin.assign(vertices + 1, 0);
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) ++topology.corner_begin[v + 1];
  }
  for (std::size_t v = 0; v < vertices; ++v) topology.corner_begin[v + 1] += topology.corner_begin[v];
  topology.corners.resize(3 * triangles.size());
  std::vector<std::uint32_t> next(topology.corner_begin.begin(), topology.corner_begin.end() - 1);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t i = 0; i < 3; ++i) topology.corners[next[triangles[t][i]]++] = 3 * t + i;
  }
}

// Returns true if the triangles at a vertex form one closed fan that faces one side.
class FanTest {
 public:
  bool is_closed(std::span<const Triangle> triangles, std::span<const std::uint32_t> corners) {
    edges_.clear();
    for (const std::uint32_t corner : corners) {
      const Triangle& t = triangles[corner / 3];
      edges_.push_back({t[(corner + 1) % 3], t[(corner + 2) % 3]});
      if (edges_.back()[0] == edges_.back()[1] || edges_.back()[0] == t[corner % 3]) return false;
    }
    std::sort(edges_.begin(), edges_.end());
    const auto begins_alike = [](const auto& a, const auto& b) { return a[0] == b[0]; };
    if (edges_.empty() || std::adjacent_find(edges_.begin(), edges_.end(), begins_alike) != edges_.end()) return false;
    std::uint32_t at = edges_.front()[0];
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const auto edge = std::lower_bound(edges_.begin(), edges_.end(), std::array<std::uint32_t, 2>{at, 0});
      if (edge == edges_.end() || (*edge)[0] != at) return false;
      at = (*edge)[1];
      if (at == edges_.front()[0]) return i + 1 == edges_.size();
    }
    return false;
  }

 private:
  std::vector<std::array<std::uint32_t, 2>> edges_;  // opposite to the vertex
};

// Counts the creases at each vertex and lists the vertices that have two.
void find_creased(std::size_t vertices, std::span<const MeshEdge> creases, RelaxTopology& topology) {
  std::vector<MeshEdge> ends;  // each crease from both ends
  for (const MeshEdge& edge : creases) {
    ends.push_back(edge);
    ends.push_back({edge[1], edge[0]});
  }
  std::sort(ends.begin(), ends.end());
  for (std::size_t i = 0; i < ends.size();) {
    std::size_t last = i;
    while (last < ends.size() && ends[last][0] == ends[i][0]) ++last;
    const std::uint32_t v = ends[i][0];
    if (v < vertices && topology.freedom[v] == RelaxTopology::Freedom::free) {
      topology.freedom[v] = last - i == 2 ? RelaxTopology::Freedom::on_crease : RelaxTopology::Freedom::stays;
      if (last - i == 2) topology.on_crease.push_back({v, {ends[i][1], ends[i + 1][1]}});
    }
    i = last;
  }
}

}  // namespace

RelaxTopology relax_topology(std::span<const Triangle> triangles, std::size_t vertices,
                             std::span<const MeshEdge> creases) {
  RelaxTopology topology;
  list_corners(triangles, vertices, topology);
  topology.freedom.assign(vertices, RelaxTopology::Freedom::stays);
  FanTest test;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    if (test.is_closed(triangles, topology.corners_of(v))) topology.freedom[v] = RelaxTopology::Freedom::free;
  }
  find_creased(vertices, creases, topology);
  return topology;
}

}  // namespace knead::remesh_detail
