// Checks of volume meshes: inverted cells before and after a deformation, and meshes of two dimensions.
#include <algorithm>
#include <array>
#include <cmath>

#include "cells/cells.h"
#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead {

namespace {

constexpr std::size_t kMaxFlatPoints = std::size_t{1} << 30;

// The scaled Jacobians of the linear cells, with the middle nodes of second-order ones; and which cells are inverted.
struct Jacobians {
  std::vector<double> values;
  std::vector<std::uint8_t> is_inverted;
};

// Returns the points of cells of two dimensions, and their copies above them.
std::vector<Vec3d> lifted(std::span<const Vec3d> points) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  const Vec3d up{0, 0, box.diagonal() > 0 ? box.diagonal() : 1};
  std::vector<Vec3d> all(points.begin(), points.end());
  for (const double part : {1.0, 0.5}) {
    for (const Vec3d& p : points) all.push_back(p + up * part);
  }
  return all;
}

// Calls use(points) with the points that the cells name.
template <class Use>
auto with_points(const VolumeCells& cells, std::span<const Vec3d> points, const Use& use) {
  return cells.is_flat ? use(lifted(points)) : use(points);
}

// Uses the formula of checkMesh for two dimensions.
double greatest_flat_aspect_ratio(const Cells& cells, std::span<const Vec3d> points) {
  double greatest = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::span<const std::uint32_t> ring = cells.corners_of(i).first(corner_count(cells.kinds[i]) / 2);
    Vec3d sum{};
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vec3d edge = points[ring[(k + 1) % ring.size()]] - points[ring[k]];
      sum += {std::abs(edge.x), std::abs(edge.y), 0};
    }
    greatest = std::max(greatest, std::max(sum.x, sum.y) / std::min(sum.x, sum.y));
  }
  return greatest;
}

Jacobians jacobians_of(const VolumeCells& cells, std::span<const Vec3d> points, int threads) {
  Jacobians result{std::vector<double>(cells.cells.size()), std::vector<std::uint8_t>(cells.size())};
  parallel_for(cells.cells.size(), kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::array<Vec3d, 8> corners;
      const CellQuality quality = cell_quality(cells.cells.kinds[i], corner_positions(cells.cells, i, points, corners));
      result.values[i] = quality.scaled_jacobian;
      result.is_inverted[i] = quality.orientation == 1 ? 0 : 1;
    }
  });
  const std::vector<double> curved = middle_jacobians(cells.cells, cells.middles, points, threads);
  for (std::size_t k = 0; k < curved.size(); ++k) {
    const std::size_t cell = cells.middles.cells[k];
    result.values[cell] = std::min(result.values[cell], curved[k]);
    if (!(curved[k] > 0)) result.is_inverted[cell] = 1;
  }
  parallel_for(cells.polyhedra.size(), kCellGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (polyhedron_orientation(cells.polyhedra[i], points) != 1) result.is_inverted[cells.cells.size() + i] = 1;
    }
  });
  return result;
}

std::vector<std::span<const std::uint32_t>> polyhedra_of(const VolumeCells& cells) {
  return {cells.polyhedra.begin(), cells.polyhedra.end()};
}

}  // namespace

void add_flat_cell(std::span<const std::uint32_t> corners, std::span<const std::uint32_t> middles,
                   std::span<const Vec3d> points, VolumeCells& cells) {
  if (points.size() > kMaxFlatPoints) throw InvalidInput("a mesh of two dimensions may have 2^30 points");
  for (const std::span<const std::uint32_t> numbers : {corners, middles}) {
    const bool are_points =
        std::all_of(numbers.begin(), numbers.end(), [&](std::uint32_t v) { return v < points.size(); });
    if (!are_points) throw InvalidInput("a cell has points that the mesh lacks");
  }
  const auto up = static_cast<std::uint32_t>(points.size());
  const std::size_t n = corners.size() == 3 ? 3 : 4;
  if (corners.size() != n || (!middles.empty() && middles.size() != n)) {
    throw InvalidInput("a cell of two dimensions must have 3 or 4 corners, and as many middle nodes or none");
  }
  const CellKind kind = n == 3 ? CellKind::wedge : CellKind::hexahedron;
  double area = 0;
  for (std::size_t k = 2; k < n; ++k) {
    area += cross(points[corners[k - 1]] - points[corners[0]], points[corners[k]] - points[corners[0]]).z;
  }
  std::array<std::uint32_t, 8> prism{};
  std::copy(corners.begin(), corners.end(), prism.begin());
  const bool base_is_forward = kind == CellKind::hexahedron;  // seen from above; VTK's wedges have the opposite order
  if ((area >= 0) != base_is_forward) std::reverse(prism.begin(), prism.begin() + static_cast<std::ptrdiff_t>(n));
  for (std::size_t k = 0; k < n; ++k) prism[n + k] = prism[k] + up;
  cells.is_flat = true;
  cells.cells.add(kind, std::span(prism).first(2 * n));
  if (middles.empty()) return;
  const auto middle_of = [&](std::uint32_t a, std::uint32_t b) {
    for (std::size_t k = 0; k < n; ++k) {
      if (std::minmax(corners[k], corners[(k + 1) % n]) == std::minmax(a, b)) return middles[k];
    }
    return a;
  };
  cells.middles.cells.push_back(cells.cells.size() - 1);
  for (const auto& [i, j] : edges_of(kind)) {
    const bool is_upright = (i < n) != (j < n);
    cells.middles.points.push_back(is_upright ? prism[i % n] + 2 * up
                                              : middle_of(prism[i % n], prism[j % n]) + (i < n ? 0 : up));
  }
  cells.middles.first.push_back(cells.middles.points.size());
}

std::vector<std::uint8_t> inverted_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads) {
  return with_points(cells, points, [&](std::span<const Vec3d> all) { return jacobians_of(cells, all, threads); })
      .is_inverted;
}

std::size_t count_inverted_since(const VolumeCells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                                 int threads) {
  std::vector<std::uint8_t> has_turned;  // of linear cells
  if (!cells.is_flat) {
    has_turned = compare_cells(cells.cells, before, after, threads, CellValues::inversions).is_inverted;
  }
  const std::vector<std::uint8_t> is_inverted = inverted_cells(cells, after, threads);
  std::vector<std::uint8_t> was_inverted;
  has_turned.resize(is_inverted.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < is_inverted.size(); ++i) {
    if (is_inverted[i] != 0 && was_inverted.empty()) was_inverted = inverted_cells(cells, before, threads);
    if (has_turned[i] != 0 || (is_inverted[i] != 0 && was_inverted[i] == 0)) ++count;
  }
  return count;
}

bool wedges_look_inward(const Cells& cells, std::span<const Vec3d> points) {
  std::size_t wedges = 0;
  std::size_t inward_wedges = 0;
  std::size_t inward = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::array<Vec3d, 8> corners;
    const bool is_wedge = cells.kinds[i] == CellKind::wedge;
    const bool is_inward = cell_quality(cells.kinds[i], corner_positions(cells, i, points, corners)).orientation == -1;
    wedges += is_wedge ? 1 : 0;
    inward_wedges += is_wedge && is_inward ? 1 : 0;
    inward += is_inward ? 1 : 0;
  }
  const std::size_t others = cells.size() - wedges;
  return inward_wedges > 0 && 10 * inward_wedges >= 9 * wedges && (others == 0 || inward - inward_wedges < others);
}

CellCheck check_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads) {
  const auto greatest = [](const std::vector<double>& values) {
    return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  };
  CellCheck check;
  CellFaceQuality faces;
  Jacobians jacobians;
  with_points(cells, points, [&](std::span<const Vec3d> all) {
    faces = cell_face_quality(cells.cells, all, polyhedra_of(cells), threads);
    jacobians = jacobians_of(cells, all, threads);
  });
  check.cells = cells.size();
  check.by_corners = cells.by_corners;
  check.inverted = static_cast<std::size_t>(std::count(jacobians.is_inverted.begin(), jacobians.is_inverted.end(), 1));
  if (!jacobians.values.empty()) {
    check.least_scaled_jacobian = *std::min_element(jacobians.values.begin(), jacobians.values.end());
  }
  check.max_non_orthogonality_deg = greatest(faces.non_orthogonality_deg);
  check.mean_non_orthogonality_deg = faces.mean_non_orthogonality_deg;
  check.max_skewness = greatest(faces.skewness);
  check.max_aspect_ratio =
      cells.is_flat ? greatest_flat_aspect_ratio(cells.cells, points) : greatest(faces.aspect_ratio);
  return check;
}

}  // namespace knead
