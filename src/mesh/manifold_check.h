// For tests: properties of a triangle mesh, by brute force and independent of mesh.h.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "knead/mesh.h"
#include "math/elementary.h"

namespace knead::test {

using HalfEdge = std::pair<std::uint32_t, std::uint32_t>;

inline std::vector<std::pair<HalfEdge, std::uint32_t>> sorted_half_edges(const Mesh& mesh) {
  std::vector<std::pair<HalfEdge, std::uint32_t>> edges;  // and the third corner
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto v = mesh.face(f);
    for (std::size_t i = 0; i < 3; ++i) edges.push_back({{v[i], v[(i + 1) % 3]}, v[(i + 2) % 3]});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

// Returns the number of components of a closed oriented manifold; -1 if the mesh is none. It is one if every face is a
// triangle of three different vertices, every edge has exactly two faces that use it in opposite directions, and the
// triangles at every vertex form one fan.
inline int closed_manifold_components(const Mesh& mesh) {
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto v = mesh.face(f);
    if (v.size() != 3 || v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) return -1;
  }
  const auto edges = sorted_half_edges(mesh);
  const auto third = [&](std::uint32_t a, std::uint32_t b) {
    const auto found = std::lower_bound(edges.begin(), edges.end(), std::pair{HalfEdge{a, b}, std::uint32_t{0}});
    return found != edges.end() && found->first == HalfEdge{a, b} ? std::int64_t{found->second} : -1;
  };
  std::vector<std::size_t> degree(mesh.vertex_count(), 0);
  std::vector<std::uint32_t> some_neighbour(mesh.vertex_count(), 0);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto [a, b] = edges[i].first;
    if (i > 0 && edges[i].first == edges[i - 1].first) return -1;
    if (third(b, a) < 0) return -1;
    ++degree[a];
    some_neighbour[a] = b;
  }
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    std::uint32_t neighbour = some_neighbour[v];
    std::size_t turned = 0;
    do {
      neighbour = static_cast<std::uint32_t>(third(v, neighbour));
      ++turned;
    } while (neighbour != some_neighbour[v] && turned <= degree[v]);
    if (degree[v] == 0 || turned != degree[v]) return -1;
  }
  std::vector<std::uint32_t> root(mesh.vertex_count());
  for (std::uint32_t v = 0; v < root.size(); ++v) root[v] = v;
  const auto find = [&](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  int components = static_cast<int>(root.size());
  for (const auto& edge : edges) {
    const std::uint32_t a = find(edge.first.first);
    const std::uint32_t b = find(edge.first.second);
    if (a != b) --components;
    root[a] = b;
  }
  return components;
}

// Returns vertices - edges + faces of a closed triangle mesh.
inline std::int64_t euler_characteristic(const Mesh& mesh) {
  return static_cast<std::int64_t>(mesh.vertex_count()) - static_cast<std::int64_t>(mesh.face_count() / 2);
}

inline std::array<Vec3d, 3> triangle(const Mesh& mesh, std::size_t f) {
  const auto v = mesh.face(f);
  return {mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]};
}

inline double enclosed_volume(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto [a, b, c] = triangle(mesh, f);
    sum += dot(a, cross(b, c));
  }
  return sum / 6;
}

// Returns the smallest angle of all triangles, in degrees.
inline double smallest_angle(const Mesh& mesh) {
  double smallest = 180;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto p = triangle(mesh, f);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d u = p[(i + 1) % 3] - p[i];
      const Vec3d v = p[(i + 2) % 3] - p[i];
      smallest = std::min(smallest, elementary::atan2(norm(cross(u, v)), dot(u, v)) * 180 / std::numbers::pi);
    }
  }
  return smallest;
}

}  // namespace knead::test
