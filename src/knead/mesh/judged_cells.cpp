#include "knead/mesh/judged_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "knead/math/error.h"
#include "knead/math/parallel.h"

namespace knead {

namespace {

constexpr std::size_t kCellsAtATime = 4096;

CellQuality quality_of(const Cells& cells, std::size_t cell, std::span<const Vec3d> points) {
  const std::span<const std::uint32_t> numbers = cells.corners_of(cell);
  std::array<Vec3d, 8> corners;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (numbers[k] >= points.size()) {
      throw InvalidInput(
          fmt::format("cell {} has the corner {}, but there are {} points", cell, numbers[k], points.size()));
    }
    corners[k] = points[numbers[k]];
  }
  return cell_quality(cells.kinds[cell], std::span(corners).first(numbers.size()));
}

// A total order, so that the order of the threads does not matter.
bool is_worse(const std::optional<WorstCell>& a, const std::optional<WorstCell>& b) {
  if (!a || !b) return a.has_value();
  return std::pair(a->scaled_jacobian, a->cell) < std::pair(b->scaled_jacobian, b->cell);
}

}  // namespace

JudgedCells::JudgedCells(const Cells& cells, std::span<const Vec3d> before, int threads, const Progress* progress)
    : cells_(cells),
      before_(before),
      threads_(threads),
      progress_(progress),
      sides_(cells.size()),
      jacobians_(cells.size()),
      volumes_(cells.size()) {
  parallel_for(cells.size(), kCellsAtATime, threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress);
    for (std::size_t i = begin; i < end; ++i) {
      const CellQuality quality = quality_of(cells, i, before);
      sides_[i] = static_cast<std::int8_t>(quality.orientation);
      jacobians_[i] = quality.orientation == -1 ? -quality.scaled_jacobian : quality.scaled_jacobian;
      volumes_[i] = quality.volume;
    }
  });
}

bool JudgedCells::is_moved(std::size_t cell, std::span<const Vec3d> after) const {
  const std::span<const std::uint32_t> corners = cells_.corners_of(cell);
  return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return after[v] != before_[v]; });
}

CellNow JudgedCells::now(std::size_t cell, std::span<const Vec3d> after) const {
  if (!is_moved(cell, after)) return {volumes_[cell] / volumes_[cell], jacobians_[cell], false};
  const CellQuality quality = quality_of(cells_, cell, after);
  const bool was_inside_out = sides_[cell] == -1;
  return {quality.volume / volumes_[cell], was_inside_out ? -quality.scaled_jacobian : quality.scaled_jacobian,
          sides_[cell] != 0 && quality.orientation != sides_[cell]};
}

std::optional<WorstCell> JudgedCells::worst_spoiled(std::span<const Vec3d> after, double bound) const {
  std::optional<WorstCell> worst;
  std::mutex mutex;
  parallel_for(cells_.size(), kCellsAtATime, threads_, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress_);
    std::optional<WorstCell> own;
    for (std::size_t i = begin; i < end; ++i) {
      if (sides_[i] == 0 || !is_moved(i, after)) continue;
      const CellNow cell = now(i, after);
      const bool is_spoiled = cell.is_inverted || is_below(i, cell.scaled_jacobian, bound);
      if (is_spoiled && is_worse(WorstCell{i, cell.scaled_jacobian}, own)) own = WorstCell{i, cell.scaled_jacobian};
    }
    const std::scoped_lock lock(mutex);
    if (is_worse(own, worst)) worst = own;
  });
  return worst;
}

}  // namespace knead
