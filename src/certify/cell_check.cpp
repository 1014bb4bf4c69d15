// Whether the cells of a volume mesh are good.
#include <algorithm>
#include <array>

#include "cells/cells.h"
#include "knead/cells.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"

namespace knead {

namespace {

constexpr std::size_t kCellsTogether = 1024;

// Of the linear cells, in which those of the second order have that of their corners and middle nodes.
struct Jacobians {
  std::vector<double> values;
  std::vector<std::uint8_t> is_inverted;
};

Jacobians jacobians_of(const VolumeCells& cells, std::span<const Vec3d> points, int threads) {
  Jacobians result{std::vector<double>(cells.cells.size()), std::vector<std::uint8_t>(cells.size())};
  parallel_for(cells.cells.size(), kCellsTogether, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::array<Vec3d, 8> corners;
      const std::span<const std::uint32_t> numbers = cells.cells.corners_of(i);
      std::transform(numbers.begin(), numbers.end(), corners.begin(), [&](std::uint32_t v) { return points[v]; });
      const CellQuality quality = cell_quality(cells.cells.kinds[i], std::span(corners).first(numbers.size()));
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
  parallel_for(cells.polyhedra.size(), kCellsTogether, threads, [&](std::size_t begin, std::size_t end) {
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

std::vector<std::uint8_t> inverted_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads) {
  return jacobians_of(cells, points, threads).is_inverted;
}

CellCheck check_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads) {
  const auto greatest = [](const std::vector<double>& values) {
    return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  };
  CellCheck check;
  const CellFaceQuality faces = cell_face_quality(cells.cells, points, polyhedra_of(cells), threads);
  const Jacobians jacobians = jacobians_of(cells, points, threads);
  check.cells = cells.size();
  check.inverted = static_cast<std::size_t>(std::count(jacobians.is_inverted.begin(), jacobians.is_inverted.end(), 1));
  if (!jacobians.values.empty()) {
    check.least_scaled_jacobian = *std::min_element(jacobians.values.begin(), jacobians.values.end());
  }
  check.max_non_orthogonality_deg = greatest(faces.non_orthogonality_deg);
  check.mean_non_orthogonality_deg = faces.mean_non_orthogonality_deg;
  check.max_skewness = greatest(faces.skewness);
  check.max_aspect_ratio = greatest(faces.aspect_ratio);
  return check;
}

std::size_t count_new_inversions(const VolumeCells& cells, std::span<const Vec3d> before,
                                 std::span<const Vec3d> after) {
  const std::vector<std::uint8_t> was = inverted_cells(cells, before);
  const std::vector<std::uint8_t> is = inverted_cells(cells, after);
  std::size_t count = 0;
  for (std::size_t i = 0; i < is.size(); ++i) count += is[i] != 0 && was[i] == 0 ? 1 : 0;
  return count;
}

}  // namespace knead
