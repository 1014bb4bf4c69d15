#include "knead/remesh/free_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "knead/math/parallel.h"
#include "knead/mesh/cell_shape.h"
#include "knead/remesh/vertex_star.h"

namespace knead::remesh_detail {

namespace {

constexpr std::size_t kCellsAtATime = 4096;
constexpr std::size_t kVerticesAtATime = 16;
constexpr std::uint8_t kUnknown = 2;
constexpr std::uint8_t kNoColor = 255;
constexpr std::uint8_t kMostColors = 64;

// Of those cells only.
CellStars stars_of(const Cells& cells, const std::vector<std::uint32_t>& numbers, std::size_t points) {
  CellStars stars{std::vector<std::size_t>(points + 1), {}};
  for (const std::uint32_t cell : numbers) {
    for (const std::uint32_t corner : cells.corners_of(cell)) ++stars.first[corner + 1];
  }
  for (std::size_t v = 0; v < points; ++v) stars.first[v + 1] += stars.first[v];
  stars.cells.resize(stars.first.back());
  std::vector<std::size_t> next(stars.first.begin(), stars.first.end() - 1);
  for (const std::uint32_t cell : numbers) {
    for (const std::uint32_t corner : cells.corners_of(cell)) stars.cells[next[corner]++] = cell;
  }
  return stars;
}

// Sorts numbers and keeps one of each. `marks` has a 0 for each number that may occur, before and after.
void make_unique(std::vector<std::uint32_t>& numbers, std::vector<std::uint8_t>& marks) {
  std::erase_if(numbers, [&](std::uint32_t n) { return std::exchange(marks[n], std::uint8_t{1}) != 0; });
  for (const std::uint32_t n : numbers) marks[n] = 0;
  std::sort(numbers.begin(), numbers.end());
}

}  // namespace

FreeVertices::FreeVertices(const JudgedCells& judged, std::span<const Vec3d> whole, const CellOptions& options)
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

// The vertices of cells with corners at one place stay where the deformation moves them.
void FreeVertices::fix_collapsed(std::uint32_t cell) {
  const std::span<const std::uint32_t> numbers = judged_.cells().corners_of(cell);
  std::array<Vec3d, 8> corners;
  for (std::size_t k = 0; k < numbers.size(); ++k) corners[k] = judged_.before()[numbers[k]];
  if (!is_collapsed(shape_of(judged_.cells().kinds[cell]), std::span<const Vec3d>(corners).first(numbers.size())))
    return;
  for (const std::uint32_t v : numbers) freedom_[v] = 0;
}

double FreeVertices::quality_of(std::size_t cell, std::span<const Vec3d> points) const {
  if (judged_.side(cell) == 0) return 1;
  const std::span<const std::uint32_t> numbers = judged_.cells().corners_of(cell);
  std::array<Vec3d, 8> corners;
  for (std::size_t k = 0; k < numbers.size(); ++k) corners[k] = points[numbers[k]];
  return judged_.side(cell) *
         scaled_jacobian(shape_of(judged_.cells().kinds[cell]), std::span<const Vec3d>(corners).first(numbers.size()));
}

void FreeVertices::measure(std::span<const Vec3d> points) {
  parallel_for(active_.size(), kCellsAtATime, options_.threads, [&](std::size_t begin, std::size_t end) {
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
    // Good cells next to bad ones may leave them no room: they become better, too.
    sweep(bad, round == 0 ? 0 : 1 + std::max(idle, round / 8), points, moved);
  }
}

void FreeVertices::find_freedom(std::uint32_t vertex) {
  std::uint8_t& freedom = freedom_[vertex];
  if (freedom == kUnknown) freedom = is_on_boundary(judged_.cells(), stars_, vertex) ? 0 : 1;
}

// Returns the free vertices of the cells and of so many rings of cells around them.
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
  parallel_for(vertices.size(), kVerticesAtATime, options_.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) find_freedom(vertices[i]);
  });
  std::erase_if(vertices, [&](std::uint32_t v) { return freedom_[v] == 0; });
  return vertices;
}

// Returns sets of the vertices, so that no two of a set have a common cell. Of vertices with more than 64 neighbours
// each may be a set of its own.
std::vector<std::vector<std::uint32_t>> FreeVertices::apart(const std::vector<std::uint32_t>& vertices) {
  std::vector<std::vector<std::uint32_t>> sets(kMostColors);
  for (const std::uint32_t v : vertices) {
    std::uint64_t taken = 0;
    for (const std::uint32_t cell : stars_.of(v)) {
      for (const std::uint32_t corner : judged_.cells().corners_of(cell)) {
        if (colors_[corner] < kMostColors) taken |= std::uint64_t{1} << colors_[corner];
      }
    }
    const int color = std::countr_one(taken);
    if (color == kMostColors) {
      sets.push_back({v});
    } else {
      colors_[v] = static_cast<std::uint8_t>(color);
      sets[static_cast<std::size_t>(color)].push_back(v);
    }
  }
  for (const std::uint32_t v : vertices) colors_[v] = kNoColor;
  return sets;
}

// Raises the vertices of bad cells to the bound, or, with `rings` of cells around, to twice that for each ring.
void FreeVertices::sweep(const std::vector<std::uint32_t>& bad, int rings, std::span<Vec3d> points,
                         std::vector<std::uint8_t>& moved) {
  const double goal = std::min(0.5, options_.least_scaled_jacobian * (rings == 0 ? 1.1 : 2.0 * rings));
  for (const std::vector<std::uint32_t>& set : apart(free_corners(bad, rings))) {
    parallel_for(set.size(), kVerticesAtATime, options_.threads, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(options_.progress);
      VertexStar star;
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t v = set[i];
        const std::span<const std::uint32_t> cells = stars_.of(v);
        if (std::none_of(cells.begin(), cells.end(), [&](std::uint32_t c) { return qualities_[c] < goal; })) continue;
        star.read(judged_, stars_, points, v);
        star.raise(goal);
        if (star.place() == points[v]) continue;
        points[v] = star.place();
        moved[v] = 1;
        for (const std::uint32_t cell : cells) qualities_[cell] = quality_of(cell, points);
      }
    });
  }
}

}  // namespace knead::remesh_detail
