// Deforms volume meshes: interior vertices are free to move until the worst cells around them are good enough.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "cells/cells.h"
#include "knead/error.h"
#include "knead/remesh.h"
#include "remesh/vertex_star.h"

namespace knead {

namespace {

using detail::VertexStar;

constexpr std::size_t kSumGrain = 4096;
constexpr std::size_t kVertexGrain = 16;
constexpr std::uint8_t kUnknown = 2;
constexpr std::uint8_t kNoColor = 255;
constexpr std::uint8_t kMaxColors = 64;

// Sorts numbers and keeps one of each. `marks` has a 0 for each number that may occur, before and after.
void make_unique(std::vector<std::uint32_t>& numbers, std::vector<std::uint8_t>& marks) {
  std::erase_if(numbers, [&](std::uint32_t n) { return std::exchange(marks[n], std::uint8_t{1}) != 0; });
  for (const std::uint32_t n : numbers) marks[n] = 0;
  std::sort(numbers.begin(), numbers.end());
}

// The vertices of one mesh that may leave the path of the deformation.
class FreeVertices {
 public:
  // whole: the points after the whole motion. Vertices that it leaves at rest are not free. All must outlive this.
  FreeVertices(const CellBaseline& judged, std::span<const Vec3d> whole, const CellOptions& options);

  // Moves free vertices around bad cells and marks them in `moved`. Gives up if a cell is still inverted after
  // `patience` rounds.
  void improve(std::span<Vec3d> points, std::vector<std::uint8_t>& moved, int patience);

 private:
  double quality_of(std::size_t cell, std::span<const Vec3d> points) const;
  void fix_collapsed(std::uint32_t cell);
  void measure(std::span<const Vec3d> points);
  void find_freedom(std::uint32_t vertex);
  std::vector<std::uint32_t> free_corners(const std::vector<std::uint32_t>& cells, int rings);
  std::vector<std::vector<std::uint32_t>> apart(const std::vector<std::uint32_t>& vertices);
  void sweep(const std::vector<std::uint32_t>& bad, int rings, std::span<Vec3d> points,
             std::vector<std::uint8_t>& moved);

  const CellBaseline& judged_;
  const CellOptions& options_;
  std::vector<std::uint32_t> active_;  // the cells that the whole motion moves
  CellStars stars_;                    // of these cells
  std::vector<double> qualities_;      // of all cells; kept up only for active ones
  std::vector<std::uint8_t> freedom_;  // of each vertex: 0, 1 or kUnknown
  std::vector<std::uint8_t> colors_;
  std::vector<std::uint8_t> vertex_marks_;  // all 0 between calls of make_unique()
  std::vector<std::uint8_t> cell_marks_;
};

FreeVertices::FreeVertices(const CellBaseline& judged, std::span<const Vec3d> whole, const CellOptions& options)
    : judged_(judged),
      options_(options),
      qualities_(judged.cells().size(), 1),
      freedom_(whole.size(), kUnknown),
      colors_(whole.size(), kNoColor),
      vertex_marks_(whole.size()),
      cell_marks_(judged.cells().size()) {
  for (std::uint32_t i = 0; i < judged.cells().size(); ++i) {
    if (judged.is_moved(i, whole)) active_.push_back(i);
  }
  stars_ = stars_of(judged.cells(), active_, whole.size());
  for (const std::uint32_t cell : active_) fix_collapsed(cell);
  for (std::size_t v = 0; v < whole.size(); ++v) {
    const bool is_fixed = !options.fixed.empty() && options.fixed[v] != 0;
    if (is_fixed || whole[v] == judged.before()[v]) freedom_[v] = 0;
  }
}

// The vertices of cells with corners at one position stay where the deformation moves them.
void FreeVertices::fix_collapsed(std::uint32_t cell) {
  std::array<Vec3d, 8> corners;
  const Cells& cells = judged_.cells();
  if (!is_collapsed(shape_of(cells.kinds[cell]), corner_positions(cells, cell, judged_.before(), corners))) return;
  for (const std::uint32_t v : cells.corners_of(cell)) freedom_[v] = 0;
}

double FreeVertices::quality_of(std::size_t cell, std::span<const Vec3d> points) const {
  if (judged_.side(cell) == 0) return 1;
  std::array<Vec3d, 8> corners;
  const Cells& cells = judged_.cells();
  return judged_.side(cell) *
         scaled_jacobian(shape_of(cells.kinds[cell]), corner_positions(cells, cell, points, corners));
}

void FreeVertices::measure(std::span<const Vec3d> points) {
  parallel_for(active_.size(), kSumGrain, options_.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(options_.progress);
    for (std::size_t i = begin; i < end; ++i) qualities_[active_[i]] = quality_of(active_[i], points);
  });
}

void FreeVertices::improve(std::span<Vec3d> points, std::vector<std::uint8_t>& moved, int patience) {
  measure(points);
  std::size_t bad_before = active_.size() + 1;
  double least_before = -2;
  int idle = 0;
  for (int round = 0; round < options_.rounds && idle < 3; ++round) {
    std::vector<std::uint32_t> bad;
    double least = 1;
    for (const std::uint32_t cell : active_) {
      least = std::min(least, qualities_[cell]);
      if (judged_.is_below(cell, qualities_[cell], options_.least_scaled_jacobian)) bad.push_back(cell);
    }
    if (bad.empty() || (round >= patience && least < 0)) return;
    idle = bad.size() < bad_before || least > least_before + 1e-3 ? 0 : idle + 1;
    bad_before = std::min(bad_before, bad.size());
    least_before = std::max(least_before, least);
    // Improves good cells next to bad ones, too, since these may leave no room.
    sweep(bad, round == 0 ? 0 : 1 + std::max(idle, round / 8), points, moved);
  }
}

void FreeVertices::find_freedom(std::uint32_t vertex) {
  std::uint8_t& freedom = freedom_[vertex];
  if (freedom == kUnknown) freedom = is_on_boundary(judged_.cells(), stars_, vertex) ? 0 : 1;
}

// Returns the free vertices of the cells and of `rings` rings of cells around them.
std::vector<std::uint32_t> FreeVertices::free_corners(const std::vector<std::uint32_t>& cells, int rings) {
  std::vector<std::uint32_t> around = cells;
  std::vector<std::uint32_t> vertices;
  for (int ring = 0; ring <= rings; ++ring) {
    vertices.clear();
    for (const std::uint32_t cell : around) {
      const std::span<const std::uint32_t> corners = judged_.cells().corners_of(cell);
      vertices.insert(vertices.end(), corners.begin(), corners.end());
    }
    make_unique(vertices, vertex_marks_);
    if (ring == rings) break;
    around.clear();
    for (const std::uint32_t v : vertices) {
      const std::span<const std::uint32_t> star = stars_.of(v);
      around.insert(around.end(), star.begin(), star.end());
    }
    make_unique(around, cell_marks_);
  }
  parallel_for(vertices.size(), kVertexGrain, options_.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) find_freedom(vertices[i]);
  });
  std::erase_if(vertices, [&](std::uint32_t v) { return freedom_[v] == 0; });
  return vertices;
}

// Divides the vertices into sets in which no two have a common cell. A vertex with more than 64 neighbours may form a
// set of its own.
std::vector<std::vector<std::uint32_t>> FreeVertices::apart(const std::vector<std::uint32_t>& vertices) {
  std::vector<std::vector<std::uint32_t>> sets(kMaxColors);
  for (const std::uint32_t v : vertices) {
    std::uint64_t taken = 0;
    for (const std::uint32_t cell : stars_.of(v)) {
      for (const std::uint32_t corner : judged_.cells().corners_of(cell)) {
        if (colors_[corner] < kMaxColors) taken |= std::uint64_t{1} << colors_[corner];
      }
    }
    const int color = std::countr_one(taken);
    if (color == kMaxColors) {
      sets.push_back({v});
    } else {
      colors_[v] = static_cast<std::uint8_t>(color);
      sets[static_cast<std::size_t>(color)].push_back(v);
    }
  }
  for (const std::uint32_t v : vertices) colors_[v] = kNoColor;
  return sets;
}

// Moves vertices of bad cells until the cells reach the bound; with rings of cells around, twice the bound per ring.
void FreeVertices::sweep(const std::vector<std::uint32_t>& bad, int rings, std::span<Vec3d> points,
                         std::vector<std::uint8_t>& moved) {
  const double goal = std::min(0.5, options_.least_scaled_jacobian * (rings == 0 ? 1.1 : 2.0 * rings));
  for (const std::vector<std::uint32_t>& set : apart(free_corners(bad, rings))) {
    parallel_for(set.size(), kVertexGrain, options_.threads, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(options_.progress);
      VertexStar star;
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t v = set[i];
        const std::span<const std::uint32_t> cells = stars_.of(v);
        if (std::none_of(cells.begin(), cells.end(), [&](std::uint32_t c) { return qualities_[c] < goal; })) continue;
        star.read(judged_, stars_, points, v);
        star.raise(goal);
        if (star.position() == points[v]) continue;
        points[v] = star.position();
        moved[v] = 1;
        for (const std::uint32_t cell : cells) qualities_[cell] = quality_of(cell, points);
      }
    });
  }
}

constexpr int kMaxParts = 32;
constexpr int kMaxInvertedRounds = 5;  // cells that are still inverted after these need a smaller part of the motion

// Sums in the order of the cells, for every number of threads.
CellSummary summary_of(const CellBaseline& judged, std::span<const Vec3d> after, const CellOptions& options) {
  struct Sums {
    CellSummary summary;  // the mean is a sum here
    std::size_t counted = 0;
  };
  const std::size_t count = judged.cells().size();
  std::vector<Sums> parts((count + kSumGrain - 1) / kSumGrain);
  parallel_for(count, kSumGrain, options.threads, [&](std::size_t begin, std::size_t end) {
    Sums& part = parts[begin / kSumGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const DeformedCell now = judged.now(i, after);
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
  Sums all;
  for (const Sums& part : parts) {
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
  const CellBaseline judged(cells, before, options.threads, options.progress);
  result.flow = summary_of(judged, whole, options);
  result.result = result.flow;
  result.points = whole;
  if (result.flow.below == 0) return result;
  FreeVertices vertices(judged, whole, options);
  for (const int parts : {1, 8, kMaxParts}) {
    std::vector<Vec3d> points = parts == 1 ? whole : std::vector<Vec3d>(before.begin(), before.end());
    std::vector<std::uint8_t> moved(before.size());
    for (int part = 0; part < parts; ++part) {
      if (parts > 1) carry(static_cast<double>(part) / parts, static_cast<double>(part + 1) / parts, points);
      // Vertices that were not freed end where the whole motion takes them.
      if (parts > 1 && part + 1 == parts) {
        for (std::size_t v = 0; v < points.size(); ++v) {
          if (moved[v] == 0) points[v] = whole[v];
        }
      }
      vertices.improve(points, moved, parts < kMaxParts ? kMaxInvertedRounds : options.rounds);
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
