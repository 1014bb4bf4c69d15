// Interior vertices of volume meshes are free: they move until the worst cells around them are good enough.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "knead/math/error.h"
#include "knead/math/parallel.h"
#include "knead/mesh/cell_shape.h"
#include "knead/remesh/remesh.h"

namespace knead {

namespace {

constexpr std::size_t kCellsAtATime = 4096;
constexpr double kWideMargin = 0.1;  // cells whose quality is so much above the least count as worst, too

// The cells around each vertex.
struct Stars {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> cells;

  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(cells).subspan(first[vertex], first[vertex + 1] - first[vertex]);
  }
};

Stars stars_of(const Cells& cells, std::size_t points) {
  Stars stars{std::vector<std::size_t>(points + 1), std::vector<std::uint32_t>(cells.corners.size())};
  for (const std::uint32_t corner : cells.corners) ++stars.first[corner + 1];
  for (std::size_t v = 0; v < points; ++v) stars.first[v + 1] += stars.first[v];
  std::vector<std::size_t> next(stars.first.begin(), stars.first.end() - 1);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::uint32_t corner : cells.corners_of(i)) stars.cells[next[corner]++] = static_cast<std::uint32_t>(i);
  }
  return stars;
}

// Returns whether a face at the vertex belongs to one cell only, or to more than two.
bool is_on_boundary(const Cells& cells, const Stars& stars, std::uint32_t vertex) {
  std::vector<std::array<std::uint32_t, 4>> faces;
  for (const std::uint32_t cell : stars.of(vertex)) {
    const std::span<const std::uint32_t> corners = cells.corners_of(cell);
    for (const CellFace& face : shape_of(cells.kinds[cell]).faces) {
      std::array<std::uint32_t, 4> key{corners[face[0]], corners[face[1]], corners[face[2]], corners[face[3]]};
      if (std::find(key.begin(), key.end(), vertex) == key.end()) continue;
      if (face[3] == face[0]) key[3] = std::numeric_limits<std::uint32_t>::max();
      std::sort(key.begin(), key.end());
      faces.push_back(key);
    }
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i;
    while (end < faces.size() && faces[end] == faces[i]) ++end;
    if (end - i != 2) return true;
    i = end;
  }
  return false;
}

// What the search for a vertex's place sees: the cells around it, their corners, and their quality here.
class Star {
 public:
  Star(const Cells& cells, const std::vector<std::int8_t>& sides, const Stars& stars, std::span<const Vec3d> points,
       std::uint32_t vertex)
      : place_(points[vertex]) {
    for (const std::uint32_t cell : stars.of(vertex)) {
      if (sides[cell] == 0) continue;
      const std::span<const std::uint32_t> numbers = cells.corners_of(cell);
      Around around{&shape_of(cells.kinds[cell]), {}, numbers.size(), 0, static_cast<double>(sides[cell])};
      for (std::size_t k = 0; k < numbers.size(); ++k) {
        around.corners[k] = points[numbers[k]];
        if (numbers[k] == vertex) around.at = k;
        size_ = std::max(size_, norm(points[numbers[k]] - place_));
      }
      cells_.push_back(around);
    }
    gradients_.resize(cells_.size());
    qualities_.resize(cells_.size());
    measure();
  }

  double least() const { return least_; }
  const Vec3d& place() const { return place_; }

  // Moves the vertex until the least quality is `goal`, or grows no more. It never falls.
  void raise(double goal) {
    constexpr int most_steps = 12;
    if (cells_.empty() || !(size_ > 0)) return;
    for (int step = 0; step < most_steps && least_ < goal; ++step) {
      look_around();
      if (!climb(kWideMargin) && !climb(0.1 * kWideMargin)) return;
    }
  }

 private:
  struct Around {
    const CellShape* shape;
    std::array<Vec3d, 8> corners;
    std::size_t count;
    std::size_t at;  // the vertex among the corners
    double side;
  };

  static double quality(Around& cell, const Vec3d& place) {
    cell.corners[cell.at] = place;
    return cell.side * scaled_jacobian(*cell.shape, std::span<const Vec3d>(cell.corners).first(cell.count));
  }

  void measure() { least_ = least_at(place_); }

  double least_at(const Vec3d& place) {
    double least = std::numeric_limits<double>::infinity();
    for (Around& cell : cells_) {
      least = std::min(least, quality(cell, place));
      if (least < least_) return least;
    }
    return least;
  }

  // Measures each cell, and of the worst ones how their quality grows with the vertex's place.
  void look_around() {
    const double h = 1e-6 * size_;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      qualities_[i] = quality(cells_[i], place_);
      if (qualities_[i] > least_ + kWideMargin) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3d up = place_;
        Vec3d down = place_;
        up[axis] += h;
        down[axis] -= h;
        gradients_[i][axis] = (quality(cells_[i], up) - quality(cells_[i], down)) / (2 * h);
      }
    }
  }

  // Returns the direction in which the worst cells, those within `margin` of the least, all grow: the shortest vector
  // in the hull of their gradients (Gilbert's method).
  Vec3d uphill(double margin) const {
    std::vector<Vec3d> active;
    for (std::size_t i = 0; i < qualities_.size(); ++i) {
      if (qualities_[i] <= least_ + margin) active.push_back(gradients_[i]);
    }
    Vec3d shortest = active.front();
    for (int round = 0; round < 30; ++round) {
      Vec3d next = active.front();
      for (const Vec3d& g : active) {
        if (dot(g, shortest) < dot(next, shortest)) next = g;
      }
      const Vec3d way = next - shortest;
      const double along = -dot(shortest, way);
      if (!(along > 1e-6 * norm2(shortest))) break;
      shortest += way * std::min(1.0, along / norm2(way));
    }
    return shortest;
  }

  bool climb(double margin) {
    const Vec3d way = uphill(margin);
    const double length = norm(way);
    if (!(length > 1e-9 / size_)) return false;
    const double before = least_;
    Vec3d best = place_;
    double step = 0.5 * size_ / length;
    for (int halving = 0; halving < 14; ++halving, step *= 0.5) {
      const Vec3d there = place_ + way * step;
      const double least = least_at(there);
      if (least > least_) {
        best = there;
        least_ = least;
      } else if (least_ > before) {
        break;
      }
    }
    place_ = best;
    return least_ > before + 1e-6;
  }

  std::vector<Around> cells_;
  std::vector<Vec3d> gradients_;
  std::vector<double> qualities_;
  Vec3d place_;
  double size_ = 0;  // the longest edge
  double least_ = -std::numeric_limits<double>::infinity();
};

// The work on one mesh.
class FreeVertices {
 public:
  FreeVertices(const Cells& cells, std::span<const Vec3d> before, const CellOptions& options)
      : cells_(cells), before_(before), options_(options), sides_(cells.size()), is_free_(before.size(), kUnknown) {
    for (std::size_t v = 0; v < options.fixed.size(); ++v) {
      if (options.fixed[v] != 0) is_free_[v] = 0;
    }
    parallel_for(cells.size(), kCellsAtATime, options.threads, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(options.progress);
      std::array<Vec3d, 8> corners;
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t count = copy_corners(i, before, corners);
        sides_[i] = static_cast<std::int8_t>(cell_quality(cells.kinds[i], std::span(corners).first(count)).orientation);
      }
    });
  }

  // Moves the vertices around bad cells; marks them in `moved`.
  void improve(std::span<Vec3d> points, std::vector<std::uint8_t>& moved) {
    std::vector<double> quality = qualities(points);
    std::size_t bad_before = cells_.size() + 1;
    double least_before = -2;
    int idle = 0;
    for (int round = 0; round < options_.rounds && idle < 3; ++round) {
      std::vector<std::uint32_t> bad;
      double least = 1;
      for (std::size_t i = 0; i < quality.size(); ++i) {
        least = std::min(least, quality[i]);
        if (quality[i] < options_.least_scaled_jacobian) bad.push_back(static_cast<std::uint32_t>(i));
      }
      if (bad.empty()) return;
      idle = bad.size() < bad_before || least > least_before + 1e-3 ? 0 : idle + 1;
      bad_before = std::min(bad_before, bad.size());
      least_before = std::max(least_before, least);
      // Good cells next to bad ones may leave them no room: they become better, too.
      sweep(bad, round == 0 ? 0 : 1 + idle, points, quality, moved);
    }
  }

 private:
  static constexpr std::uint8_t kUnknown = 2;

  std::size_t copy_corners(std::size_t cell, std::span<const Vec3d> points, std::array<Vec3d, 8>& corners) const {
    const std::span<const std::uint32_t> numbers = cells_.corners_of(cell);
    for (std::size_t k = 0; k < numbers.size(); ++k) corners[k] = points[numbers[k]];
    return numbers.size();
  }

  double quality_of(std::size_t cell, std::span<const Vec3d> points) const {
    if (sides_[cell] == 0) return 1;
    std::array<Vec3d, 8> corners;
    const std::size_t count = copy_corners(cell, points, corners);
    return sides_[cell] * scaled_jacobian(shape_of(cells_.kinds[cell]), std::span<const Vec3d>(corners).first(count));
  }

  std::vector<double> qualities(std::span<const Vec3d> points) const {
    std::vector<double> quality(cells_.size());
    parallel_for(cells_.size(), kCellsAtATime, options_.threads, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(options_.progress);
      for (std::size_t i = begin; i < end; ++i) quality[i] = quality_of(i, points);
    });
    return quality;
  }

  bool is_free(std::uint32_t vertex) {
    if (is_free_[vertex] == kUnknown) is_free_[vertex] = is_on_boundary(cells_, stars(), vertex) ? 0 : 1;
    return is_free_[vertex] == 1;
  }

  const Stars& stars() {
    if (stars_.first.empty()) stars_ = stars_of(cells_, before_.size());
    return stars_;
  }

  // Raises the vertices of bad cells to the bound, or, with `rings` of cells around, to twice that for each ring.
  void sweep(const std::vector<std::uint32_t>& bad, int rings, std::span<Vec3d> points, std::vector<double>& quality,
             std::vector<std::uint8_t>& moved) {
    const auto vertices_of = [&](const std::vector<std::uint32_t>& around) {
      std::vector<std::uint32_t> vertices;
      for (const std::uint32_t cell : around) {
        const std::span<const std::uint32_t> corners = cells_.corners_of(cell);
        vertices.insert(vertices.end(), corners.begin(), corners.end());
      }
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
      return vertices;
    };
    std::vector<std::uint32_t> vertices = vertices_of(bad);
    for (int ring = 0; ring < rings; ++ring) {
      std::vector<std::uint32_t> around;
      for (const std::uint32_t v : vertices) {
        const std::span<const std::uint32_t> star = stars().of(v);
        around.insert(around.end(), star.begin(), star.end());
      }
      vertices = vertices_of(around);
    }
    const double goal = std::min(0.5, options_.least_scaled_jacobian * (rings == 0 ? 1.1 : 2.0 * rings));
    for (const std::uint32_t v : vertices) {
      stop_if_cancelled(options_.progress);
      if (points[v] == before_[v] || !is_free(v)) continue;
      Star star(cells_, sides_, stars(), points, v);
      if (!(star.least() < goal)) continue;
      star.raise(goal);
      if (star.place() == points[v]) continue;
      points[v] = star.place();
      moved[v] = 1;
      for (const std::uint32_t cell : stars().of(v)) quality[cell] = quality_of(cell, points);
    }
  }

  const Cells& cells_;
  std::span<const Vec3d> before_;
  const CellOptions& options_;
  std::vector<std::int8_t> sides_;  // the orientation before
  std::vector<std::uint8_t> is_free_;
  Stars stars_;
};

CellSummary summary_of(const Cells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after, int threads) {
  const CellChanges changes = compare_cells(cells, before, after, threads);
  CellSummary summary;
  summary.inverted = changes.inverted;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!std::isfinite(changes.volume_ratio[i])) continue;
    summary.least_scaled_jacobian = std::min(summary.least_scaled_jacobian, changes.scaled_jacobian[i]);
    sum += std::abs(changes.volume_ratio[i] - 1);
    ++count;
  }
  summary.mean_volume_change = count > 0 ? sum / static_cast<double>(count) : 0;
  return summary;
}

bool is_better(const CellSummary& a, const CellSummary& b) {
  if (a.inverted != b.inverted) return a.inverted < b.inverted;
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
  result.flow = summary_of(cells, before, whole, options.threads);
  result.result = result.flow;
  result.points = whole;
  if (result.flow.inverted == 0 && result.flow.least_scaled_jacobian >= options.least_scaled_jacobian) return result;
  FreeVertices vertices(cells, before, options);
  for (const int parts : {1, 8, 32}) {
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
      vertices.improve(points, moved);
    }
    const CellSummary summary = summary_of(cells, before, points, options.threads);
    if (is_better(summary, result.result)) {
      result.result = summary;
      result.points = std::move(points);
      result.parts = parts;
      result.freed = static_cast<std::size_t>(std::count(moved.begin(), moved.end(), 1));
    }
    const bool is_enough = summary.inverted == 0 && summary.least_scaled_jacobian >= options.least_scaled_jacobian;
    if (is_enough) break;
  }
  return result;
}

}  // namespace knead
