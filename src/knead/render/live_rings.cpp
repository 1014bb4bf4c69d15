#include "knead/render/live_rings.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace knead::render {
namespace {

// The vertices after and before a corner.
using Sides = std::pair<std::uint32_t, std::uint32_t>;

// Longer lists are left as they come, every corner a chain of its own: ordering takes the square of their length.
constexpr std::size_t kMostOrdered = 256;

// Reorders the corners into chains in which the vertex before one is the vertex after the next. A chain that is open
// begins at its end.
void order_chains(std::span<Sides> corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const bool follows = i > 0 && corners[i].first == corners[i - 1].second;
    if (!follows) {
      const auto open = std::find_if(corners.begin() + i, corners.end(), [&](const Sides& c) {
        return std::none_of(corners.begin() + i, corners.end(), [&](const Sides& o) { return o.second == c.first; });
      });
      if (open != corners.end()) std::swap(corners[i], *open);
    }
    const auto next = std::find_if(corners.begin() + i + 1, corners.end(),
                                   [&](const Sides& c) { return c.first == corners[i].second; });
    if (next != corners.end()) std::swap(corners[i + 1], *next);
  }
}

void append_chains(std::span<const Sides> corners, std::vector<std::uint32_t>& list) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i == 0 || corners[i].first != corners[i - 1].second) {
      if (i > 0) list.push_back(kNoVertex);
      list.push_back(corners[i].first);
    }
    list.push_back(corners[i].second);
  }
}

}  // namespace

Rings make_rings(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups) {
  const std::size_t drawn_count = groups.corner.size();
  std::vector<std::uint32_t> begin(drawn_count + 1, 0);
  for (const std::uint32_t d : groups.corner_vertex) {
    if (d != kNoVertex) ++begin[d + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Sides> sides(begin.back());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t c = 0; c < groups.corner_vertex.size(); ++c) {
    if (groups.corner_vertex[c] == kNoVertex) continue;
    const auto [before, after] = around(mesh, faces, c);
    sides[next[groups.corner_vertex[c]]++] = {after, before};
  }
  Rings rings;
  rings.begin.reserve(drawn_count + 1);
  rings.list.reserve(sides.size() + drawn_count);
  rings.begin.push_back(0);
  for (std::size_t d = 0; d < drawn_count; ++d) {
    const std::span<Sides> corners(sides.data() + begin[d], begin[d + 1] - begin[d]);
    if (corners.size() <= kMostOrdered) order_chains(corners);
    append_chains(corners, rings.list);
    rings.begin.push_back(static_cast<std::uint32_t>(rings.list.size()));
  }
  return rings;
}

PolygonEdges polygon_edges(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups) {
  // Under the smaller vertex of each edge: the larger, and the corner that the edge begins at. Counted, then filled.
  std::vector<std::uint32_t> begin(mesh.vertex_count() + 1, 0);
  const auto for_each_edge = [&](auto visit) {
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      if (faces.normals[f] == Vec3d{}) continue;
      for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) {
        const std::uint32_t next = c + 1 == mesh.face_begin[f + 1] ? mesh.face_begin[f] : c + 1;
        visit(c, next);
      }
    }
  };
  const auto smaller = [&](std::uint32_t a, std::uint32_t b) {
    return std::min(mesh.corner_vertex[a], mesh.corner_vertex[b]);
  };
  for_each_edge([&](std::uint32_t a, std::uint32_t b) { ++begin[smaller(a, b) + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  struct Edge {
    std::uint32_t larger = 0;
    std::uint32_t from = 0;  // corners
    std::uint32_t to = 0;
  };
  std::vector<Edge> edges(begin.back());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for_each_edge([&](std::uint32_t a, std::uint32_t b) {
    edges[next[smaller(a, b)]++] = {std::max(mesh.corner_vertex[a], mesh.corner_vertex[b]), a, b};
  });
  PolygonEdges result;
  result.list.reserve(edges.size());
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    const std::span<Edge> here(edges.data() + begin[v], begin[v + 1] - begin[v]);
    std::stable_sort(here.begin(), here.end(), [](const Edge& a, const Edge& b) { return a.larger < b.larger; });
    for (std::size_t i = 0; i < here.size();) {
      std::size_t end = i + 1;
      while (end < here.size() && here[end].larger == here[i].larger) ++end;
      result.list.push_back(groups.corner_vertex[here[i].from]);
      result.list.push_back(groups.corner_vertex[here[i].to]);
      const bool two_ways = end - i == 2 && mesh.corner_vertex[here[i].from] == mesh.corner_vertex[here[i + 1].to];
      result.closed = result.closed && two_ways;
      i = end;
    }
  }
  return result;
}

}  // namespace knead::render
