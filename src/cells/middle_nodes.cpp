// The scaled Jacobians of second-order cells at their corners and middle nodes.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cells/cells.h"
#include "knead/cells.h"
#include "knead/error.h"

namespace knead {

namespace {

using Edge = std::array<std::uint8_t, 2>;

constexpr std::array<Edge, 6> kTetrahedronEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
constexpr std::array<Edge, 8> kPyramidEdges{{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}};
constexpr std::array<Edge, 9> kWedgeEdges{{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}};
constexpr std::array<Edge, 12> kHexahedronEdges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

// A cell with its nodes.
struct CurvedCell {
  const CellShape& shape;
  std::span<const Edge> edges;
  std::array<Vec3d, 8> corners{};
  std::array<Vec3d, 12> middles{};

  const Vec3d& middle(std::uint8_t a, std::uint8_t b) const {
    const auto found = std::find_if(edges.begin(), edges.end(),
                                    [&](const Edge& e) { return std::minmax(e[0], e[1]) == std::minmax(a, b); });
    return middles[static_cast<std::size_t>(found - edges.begin())];
  }
};

double scaled(const Vec3d& a, const Vec3d& b, const Vec3d& c, double regular) {
  const double lengths = norm(a) * norm(b) * norm(c);
  return lengths > 0 ? regular * (dot(cross(a, b), c) / lengths) : 0;
}

// Returns the derivative of the map at a corner along an edge.
Vec3d along(const CurvedCell& cell, std::uint8_t from, std::uint8_t to) {
  return cell.middle(from, to) * 4.0 - cell.corners[from] * 3.0 - cell.corners[to];
}

// Returns the derivative of the map of a face at the middle of its edge from `a` to `b`, parallel to the other edge at
// `a`. `b` is followed by `c`, and in a face of four corners by `d`. By the shape functions of second order; those of
// four corners have no node in the middle.
Vec3d into_face(const CurvedCell& cell, std::span<const std::uint8_t> face) {
  const auto corner = [&](std::size_t k) { return cell.corners[face[k]]; };
  const auto middle = [&](std::size_t i, std::size_t k) { return cell.middle(face[i], face[k]); };
  if (face.size() == 3) {
    return (middle(1, 2) + middle(2, 0) - middle(0, 1)) * 2.0 - corner(0) - corner(2);
  }
  const Vec3d corners = corner(0) + corner(1) + corner(2) + corner(3);
  return middle(1, 2) + middle(3, 0) + (middle(2, 3) - middle(0, 1) - corners) * 0.5;
}

// The corners of a face, beginning with those of an edge; empty if the face lacks the edge. is_forward: the face, seen
// from outside, runs along the edge.
struct FaceAtEdge {
  std::array<std::uint8_t, 4> corners{};
  std::size_t size = 0;
  bool is_forward = false;
};

FaceAtEdge face_at(const CellFace& face, const Edge& edge) {
  const std::size_t size = face[3] == face[0] ? 3 : 4;
  for (std::size_t k = 0; k < size; ++k) {
    for (const bool is_forward : {true, false}) {
      const auto at = [&](std::size_t i) { return face[is_forward ? (k + i) % size : (k + size - i) % size]; };
      if (at(0) != edge[0] || at(1) != edge[1]) continue;
      FaceAtEdge found{{}, size, is_forward};
      for (std::size_t i = 0; i < size; ++i) found.corners[i] = at(i);
      return found;
    }
  }
  return {};
}

// Returns the scaled Jacobian at the middle of an edge, of the derivatives along it and into the two faces there.
double at_middle(const CurvedCell& cell, const Edge& edge) {
  Vec3d into[2];
  for (const CellFace& face : cell.shape.faces) {
    const FaceAtEdge found = face_at(face, edge);
    if (found.size == 0) continue;
    into[found.is_forward ? 0 : 1] = into_face(cell, std::span(found.corners).first(found.size));
  }
  // Seen from outside, the face that runs along the edge lies to its left.
  return scaled(cell.corners[edge[1]] - cell.corners[edge[0]], into[1], into[0], cell.shape.regular);
}

double least_jacobian(const CurvedCell& cell, bool is_pyramid) {
  double least = 1;
  for (const CellCorner& c : cell.shape.corners) {
    least = std::min(
        least, scaled(along(cell, c[0], c[1]), along(cell, c[0], c[2]), along(cell, c[0], c[3]), cell.shape.regular));
  }
  for (const Edge& edge : cell.edges) {
    if (is_pyramid && edge[1] == 4) continue;  // the apex has no map of this kind
    least = std::min(least, at_middle(cell, edge));
  }
  return least;
}

}  // namespace

std::span<const std::array<std::uint8_t, 2>> edges_of(CellKind kind) {
  switch (kind) {
    case CellKind::tetrahedron:
      return kTetrahedronEdges;
    case CellKind::pyramid:
      return kPyramidEdges;
    case CellKind::wedge:
      return kWedgeEdges;
    case CellKind::hexahedron:
      return kHexahedronEdges;
  }
  return {};
}

std::vector<double> middle_jacobians(const Cells& cells, const MiddleNodes& middles, std::span<const Vec3d> points,
                                     int threads) {
  std::vector<double> result(middles.cells.size());
  parallel_for(result.size(), kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t number = middles.cells[i];
      const auto point = [&](std::uint32_t v) {
        if (v < points.size()) return points[v];
        throw InvalidInput(fmt::format("cell {} has the node {}, but there are {} points", number, v, points.size()));
      };
      const CellKind kind = cells.kinds[number];
      CurvedCell cell{shape_of(kind), edges_of(kind)};
      const std::span<const std::uint32_t> corners = cells.corners_of(number);
      std::transform(corners.begin(), corners.end(), cell.corners.begin(), point);
      const auto nodes = std::span(middles.points).subspan(middles.first[i], middles.first[i + 1] - middles.first[i]);
      std::transform(nodes.begin(), nodes.end(), cell.middles.begin(), point);
      result[i] = least_jacobian(cell, kind == CellKind::pyramid);
    }
  });
  return result;
}

}  // namespace knead
