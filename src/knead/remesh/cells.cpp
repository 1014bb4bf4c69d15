// Interior vertices of volume meshes are free: they move until the worst cells around them are good enough.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "knead/math/error.h"
#include "knead/math/parallel.h"
#include "knead/mesh/judged_cells.h"
#include "knead/remesh/free_vertices.h"
#include "knead/remesh/remesh.h"

namespace knead {

namespace {

constexpr int kMostParts = 32;
// Rounds over cells that are inverted: what succeeds at all with so large a part has by then restored them.
constexpr int kPatience = 5;

// The sums are made in the order of the cells, whatever the threads.
CellSummary summary_of(const JudgedCells& judged, std::span<const Vec3d> after, const CellOptions& options) {
  constexpr std::size_t cells_at_a_time = 4096;
  struct Part {
    CellSummary summary;  // with the sum in the place of the mean
    std::size_t counted = 0;
  };
  const std::size_t count = judged.cells().size();
  std::vector<Part> parts((count + cells_at_a_time - 1) / cells_at_a_time);
  parallel_for(count, cells_at_a_time, options.threads, [&](std::size_t begin, std::size_t end) {
    Part& part = parts[begin / cells_at_a_time];
    for (std::size_t i = begin; i < end; ++i) {
      const CellNow now = judged.now(i, after);
      if (now.is_inverted) ++part.summary.inverted;
      if (now.is_inverted || judged.is_below(i, now.scaled_jacobian, options.least_scaled_jacobian)) {
        ++part.summary.below;
      }
      if (!std::isfinite(now.volume_ratio)) continue;
      ++part.counted;
      part.summary.least_scaled_jacobian = std::min(part.summary.least_scaled_jacobian, now.scaled_jacobian);
      part.summary.mean_volume_change += std::abs(now.volume_ratio - 1);
    }
  });
  Part all;
  for (const Part& part : parts) {
    all.summary.inverted += part.summary.inverted;
    all.summary.below += part.summary.below;
    all.summary.least_scaled_jacobian = std::min(all.summary.least_scaled_jacobian, part.summary.least_scaled_jacobian);
    all.summary.mean_volume_change += part.summary.mean_volume_change;
    all.counted += part.counted;
  }
  if (all.counted > 0) all.summary.mean_volume_change /= static_cast<double>(all.counted);
  return all.summary;
}

bool is_better(const CellSummary& a, const CellSummary& b) {
  if (a.inverted != b.inverted) return a.inverted < b.inverted;
  if (a.below != b.below) return a.below < b.below;
  return a.least_scaled_jacobian > b.least_scaled_jacobian;
}

void require_usable(const Cells& cells, std::span<const Vec3d> before, const CellOptions& options) {
  if (!options.fixed.empty() && options.fixed.size() != before.size()) {
    throw InvalidInput("`fixed` must have a value for each point");
  }
  const double least = options.least_scaled_jacobian;
  if (!(least > 0 && least <= 0.5)) throw InvalidInput("the least scaled Jacobian must be above 0 and at most 0.5");
  if (cells.size() > std::numeric_limits<std::uint32_t>::max()) throw InvalidInput("there are more than 2^32 cells");
}

}  // namespace

DeformedCells deform_cells(const Cells& cells, std::span<const Vec3d> before, const CarryPoints& carry,
                           const CellOptions& options) {
  require_usable(cells, before, options);
  DeformedCells result;
  std::vector<Vec3d> whole(before.begin(), before.end());
  carry(0, 1, whole);
  const JudgedCells judged(cells, before, options.threads, options.progress);
  result.flow = summary_of(judged, whole, options);
  result.result = result.flow;
  result.points = whole;
  if (result.flow.below == 0) return result;
  remesh_detail::FreeVertices vertices(judged, whole, options);
  for (const int parts : {1, 8, kMostParts}) {
    std::vector<Vec3d> points = parts == 1 ? whole : std::vector<Vec3d>(before.begin(), before.end());
    std::vector<std::uint8_t> moved(before.size());
    for (int part = 0; part < parts; ++part) {
      if (parts > 1) carry(static_cast<double>(part) / parts, static_cast<double>(part + 1) / parts, points);
      // Vertices that no part has freed end where the whole flow takes them.
      if (parts > 1 && part + 1 == parts) {
        for (std::size_t v = 0; v < points.size(); ++v) {
          if (moved[v] == 0) points[v] = whole[v];
        }
      }
      vertices.improve(points, moved, parts < kMostParts ? kPatience : options.rounds);
    }
    const CellSummary summary = summary_of(judged, points, options);
    if (is_better(summary, result.result)) {
      result.result = summary;
      result.points = std::move(points);
      result.parts = parts;
      result.freed = static_cast<std::size_t>(std::count(moved.begin(), moved.end(), 1));
    }
    if (summary.below == 0) break;
  }
  return result;
}

}  // namespace knead
