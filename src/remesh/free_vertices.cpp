#include "remesh/free_vertices.h"

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
#include "remesh/surface.h"

namespace knead::remesh_detail {

// The determinant, and the squared product of the edges at the corner where the determinant over that product is least.
struct SeenTetrahedron::There {
  std::array<Vec3d, 3> to;  // the other corners
  std::array<double, 3> squares;
  double determinant;
  double product = 0;
  std::size_t worst = 0;  // the corner; 3: the vertex

  There(const SeenTetrahedron& seen, const Vec3d& place)
      : to{seen.others_[0] - place, seen.others_[1] - place, seen.others_[2] - place},
        squares{norm2(to[0]), norm2(to[1]), norm2(to[2])},
        determinant(dot(to[0], seen.across_)) {
    const std::array<double, 4> products{squares[0] * seen.opposite_[0], squares[1] * seen.opposite_[1],
                                         squares[2] * seen.opposite_[2], squares[0] * squares[1] * squares[2]};
    // The sign of the factor is in the vector `across`.
    for (std::size_t k = 1; k < 4; ++k) {
      if (determinant > 0 ? products[k] > products[worst] : products[k] < products[worst]) worst = k;
    }
    product = products[worst];
  }
};

SeenTetrahedron::SeenTetrahedron(const std::array<Vec3d, 3>& others, double factor)
    : others_(others),
      across_(cross(others[1] - others[0], others[2] - others[0]) * (factor < 0 ? -1 : 1)),
      factor_(std::abs(factor)) {
  const double first = norm2(others[1] - others[0]);
  const double second = norm2(others[2] - others[1]);
  const double third = norm2(others[0] - others[2]);
  opposite_ = {first * third, first * second, second * third};
}

double SeenTetrahedron::quality(const Vec3d& place) const {
  const There there(*this, place);
  return there.product > 0 ? factor_ * (there.determinant / std::sqrt(there.product)) : 0;
}

LinearApproximation SeenTetrahedron::linear(const Vec3d& place) const {
  const There there(*this, place);
  if (!(there.product > 0)) return {0, {0, 0, 0}};
  const double root = std::sqrt(there.product);
  Vec3d relative{0, 0, 0};  // how the product grows, relative to it
  for (std::size_t k = 0; k < 3; ++k) {
    if (there.worst == 3 || there.worst == k) relative -= there.to[k] / there.squares[k];
  }
  return {factor_ * (there.determinant / root), (across_ + relative * there.determinant) * (-factor_ / root)};
}

SeenCorner SeenCorner::beside(const Vec3d& origin, const Vec3d& next, const Vec3d& last, double factor) {
  const double lengths = norm(next - origin) * norm(last - origin);
  const Vec3d across = lengths > 0 ? cross(next - origin, last - origin) / lengths : Vec3d{0, 0, 0};
  return {false, {origin, across, {}}, factor};
}

LinearApproximation SeenCorner::linear(const Vec3d& place) const {
  if (!is_vertex_) {
    const Vec3d edge = place - points_[0];
    const double length = norm(edge);
    if (!(length > 0)) return {0, {0, 0, 0}};
    const double value = dot(edge, points_[1]) / length;
    return {factor_ * value, (points_[1] - edge * (value / length)) * (factor_ / length)};
  }
  const Vec3d a = points_[0] - place;
  const Vec3d b = points_[1] - place;
  const Vec3d c = points_[2] - place;
  const double lengths = norm(a) * norm(b) * norm(c);
  if (!(lengths > 0)) return {0, {0, 0, 0}};
  const Vec3d across = cross(a, b);
  const double value = dot(across, c) / lengths;
  const Vec3d growth = (across + cross(b, c) + cross(c, a)) / -lengths;
  return {factor_ * value, (growth + (a / norm2(a) + b / norm2(b) + c / norm2(c)) * value) * factor_};
}

namespace {

constexpr std::size_t kCellsAtATime = 4096;
constexpr std::size_t kVerticesAtATime = 16;
constexpr std::uint8_t kUnknown = 2;
constexpr std::uint8_t kNoColor = 255;
constexpr std::uint8_t kMaxColors = 64;

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

// Interior vertices of volume meshes are free: they move until the worst cells around them are good enough.
namespace knead {

namespace {

constexpr int kMaxParts = 32;
// Rounds over cells that are inverted: what succeeds at all with so large a part has by then restored them.
constexpr int kPatience = 5;

// The sums are made in the order of the cells, whatever the threads.
CellSummary summary_of(const CellBaseline& judged, std::span<const Vec3d> after, const CellOptions& options) {
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
  const CellBaseline judged(cells, before, options.threads, options.progress);
  result.flow = summary_of(judged, whole, options);
  result.result = result.flow;
  result.points = whole;
  if (result.flow.below == 0) return result;
  remesh_detail::FreeVertices vertices(judged, whole, options);
  for (const int parts : {1, 8, kMaxParts}) {
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
      vertices.improve(points, moved, parts < kMaxParts ? kPatience : options.rounds);
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
