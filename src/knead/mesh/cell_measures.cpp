#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "knead/math/error.h"
#include "knead/math/parallel.h"
#include "knead/mesh/cell_shape.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/predicates.h"

namespace knead {

namespace {

constexpr std::array<CellCorner, 4> kTetrahedronCorners{{{0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 0, 2, 1}}};
constexpr std::array<CellFace, 4> kTetrahedronFaces{{{0, 2, 1, 0}, {0, 1, 3, 0}, {1, 2, 3, 1}, {2, 0, 3, 2}}};
constexpr std::array<CellCorner, 4> kPyramidCorners{{{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}}};
constexpr std::array<CellFace, 5> kPyramidFaces{{{0, 3, 2, 1}, {0, 1, 4, 0}, {1, 2, 4, 1}, {2, 3, 4, 2}, {3, 0, 4, 3}}};
constexpr std::array<CellCorner, 6> kWedgeCorners{
    {{0, 2, 1, 3}, {1, 0, 2, 4}, {2, 1, 0, 5}, {3, 4, 5, 0}, {4, 5, 3, 1}, {5, 3, 4, 2}}};
constexpr std::array<CellFace, 5> kWedgeFaces{{{0, 1, 2, 0}, {3, 5, 4, 3}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}};
constexpr std::array<CellCorner, 8> kHexahedronCorners{
    {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7}, {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}}};
constexpr std::array<CellFace, 6> kHexahedronFaces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

double determinant_of(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return dot(cross(a, b), c); }

// The predicates take no numbers that are smaller.
Vec3d without_dust(const Vec3d& p) {
  const auto kept = [](double x) { return std::abs(x) < 1e-75 ? 0.0 : x; };
  return {kept(p.x), kept(p.y), kept(p.z)};
}

}  // namespace

const CellShape& shape_of(CellKind kind) {
  static const std::array<CellShape, 4> kShapes{{{kTetrahedronCorners, kTetrahedronFaces, std::sqrt(2.0)},
                                                 {kPyramidCorners, kPyramidFaces, std::sqrt(2.0)},
                                                 {kWedgeCorners, kWedgeFaces, 2 / std::sqrt(3.0)},
                                                 {kHexahedronCorners, kHexahedronFaces, 1}}};
  return kShapes[static_cast<std::size_t>(kind)];
}

double scaled_jacobian(const CellShape& shape, std::span<const Vec3d> corners) {
  double least = std::numeric_limits<double>::infinity();
  for (const CellCorner& c : shape.corners) {
    const Vec3d a = corners[c[1]] - corners[c[0]];
    const Vec3d b = corners[c[2]] - corners[c[0]];
    const Vec3d d = corners[c[3]] - corners[c[0]];
    const double lengths = norm(a) * norm(b) * norm(d);
    const double jacobian = lengths > 0 ? determinant_of(a, b, d) / lengths : 0.0;
    least = std::min(least, shape.regular * jacobian);
  }
  return least;
}

std::size_t corner_count(CellKind kind) {
  constexpr std::array<std::size_t, 4> counts{4, 5, 6, 8};
  return counts[static_cast<std::size_t>(kind)];
}

CellQuality cell_quality(CellKind kind, std::span<const Vec3d> corners) {
  constexpr double most = 1e75;
  if (corners.size() != corner_count(kind)) throw InvalidInput("a cell of this kind has another number of corners");
  for (const Vec3d& p : corners) {
    const bool is_usable = std::abs(p.x) < most && std::abs(p.y) < most && std::abs(p.z) < most;  // false for NaN
    if (!is_usable) throw InvalidInput("a corner of the cell is not finite, or beyond 1e75");
  }
  const CellShape& shape = shape_of(kind);
  CellQuality quality;
  quality.scaled_jacobian = scaled_jacobian(shape, corners);
  int right = 0;
  int left = 0;
  for (const CellCorner& c : shape.corners) {
    const int sign = orient3d(without_dust(corners[c[0]]), without_dust(corners[c[1]]), without_dust(corners[c[2]]),
                              without_dust(corners[c[3]]));
    right += sign > 0 ? 1 : 0;
    left += sign < 0 ? 1 : 0;
  }
  const auto count = static_cast<int>(shape.corners.size());
  quality.orientation = right == count ? 1 : left == count ? -1 : 0;
  // A bilinear face encloses the mean of what its two ways to be cut enclose.
  double twelfths = 0;
  for (const CellFace& f : shape.faces) {
    const std::array<Vec3d, 4> p{corners[f[0]] - corners[0], corners[f[1]] - corners[0], corners[f[2]] - corners[0],
                                 corners[f[3]] - corners[0]};
    twelfths += determinant_of(p[0], p[1], p[2]) + determinant_of(p[0], p[2], p[3]);
    twelfths += determinant_of(p[1], p[2], p[3]) + determinant_of(p[1], p[3], p[0]);
  }
  quality.volume = twelfths / 12;
  return quality;
}

void Cells::add(CellKind kind, std::span<const std::uint32_t> numbers) {
  if (numbers.size() != corner_count(kind)) throw InvalidInput("a cell of this kind has another number of corners");
  kinds.push_back(kind);
  corners.insert(corners.end(), numbers.begin(), numbers.end());
  first.push_back(corners.size());
}

CellChanges compare_cells(const Cells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                          int threads) {
  constexpr std::size_t cells_at_a_time = 1024;
  const std::size_t count = cells.size();
  const std::size_t points = std::min(before.size(), after.size());
  CellChanges changes{std::vector<double>(count), std::vector<double>(count), std::vector<std::uint8_t>(count), 0};
  std::atomic<std::size_t> inverted{0};
  parallel_for(count, cells_at_a_time, threads, [&](std::size_t begin, std::size_t end) {
    std::array<Vec3d, 8> old;
    std::array<Vec3d, 8> now;
    for (std::size_t i = begin; i < end; ++i) {
      const std::span<const std::uint32_t> corners = cells.corners_of(i);
      for (std::size_t k = 0; k < corners.size(); ++k) {
        if (corners[k] >= points) {
          throw InvalidInput(fmt::format("cell {} has the corner {}, but there are {} points", i, corners[k], points));
        }
        old[k] = before[corners[k]];
        now[k] = after[corners[k]];
      }
      const CellQuality was = cell_quality(cells.kinds[i], std::span(old).first(corners.size()));
      const CellQuality is = cell_quality(cells.kinds[i], std::span(now).first(corners.size()));
      changes.volume_ratio[i] = is.volume / was.volume;
      changes.scaled_jacobian[i] = was.orientation == -1 ? -is.scaled_jacobian : is.scaled_jacobian;
      if (was.orientation == 0 || is.orientation == was.orientation) continue;
      changes.is_inverted[i] = 1;
      ++inverted;
    }
  });
  changes.inverted = inverted;
  return changes;
}

double polyhedron_volume(std::span<const std::uint32_t> faces, std::span<const Vec3d> points) {
  if (faces.size() < 2) return 0;
  // Seen from a corner, because large coordinates would cancel.
  const auto point = [&](std::size_t at) {
    if (std::max(faces[at], faces[1]) < points.size()) return points[faces[at]] - points[faces[1]];
    throw InvalidInput(
        fmt::format("a polyhedron has the corner {}, but there are {} points", faces[at], points.size()));
  };
  double sixths = 0;
  for (std::size_t at = 0; at < faces.size();) {
    const std::size_t count = faces[at++];
    if (count == 0 || count > faces.size() - at) throw InvalidInput("the list of a polyhedron's faces is cut off");
    Vec3d middle{0, 0, 0};
    for (std::size_t k = 0; k < count; ++k) middle += point(at + k) * (1.0 / static_cast<double>(count));
    for (std::size_t k = 0; k < count; ++k) {
      sixths += determinant_of(middle, point(at + k), point(at + (k + 1) % count));
    }
    at += count;
  }
  return sixths / 6;
}

}  // namespace knead
