// Points inside a body by the winding number along lattice lines, and points spread evenly over its surface.
#include "mesh/body_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <tuple>
#include <unordered_map>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/elementary.h"
#include "math/geometry.h"

namespace knead {

namespace {

// Turns the lattice by 1 radian about (1, 2, 3), so that its lines do not run along the edges of boxes and grids.
constexpr Mat3d kLatticeTurn{{0.573137855448987, -0.6090066421373933, 0.5482918096085999},
                             {0.740348840460782, 0.6716445041915284, -0.027879282947946255},
                             {-0.35127851212351696, 0.4219058779181122, 0.8358222520957642}};
constexpr double kMinInsideFraction = 0.5;  // of the volume; a surface with less inside counts as open
constexpr double kMaxLatticePoints = 3e7;
constexpr std::size_t kMaxEdgeSamples = 64;

// Returns the cube root of a volume. Where the unit of length changes by a power of two, its bits only move.
double cube_edge(double volume) {
  if (!(volume > 0)) return 0;
  const int third = static_cast<int>(std::floor(std::ilogb(volume) / 3.0));
  return std::ldexp(elementary::cbrt(std::ldexp(volume, -3 * third)), third);
}

// That of an open surface is what its border and `origin` close.
double signed_volume(std::span<const Vec3d> positions, std::span<const Triangle> triangles, const Vec3d& origin) {
  double sum = 0;
  for (const Triangle& t : triangles) {
    sum += dot(positions[t[0]] - origin, cross(positions[t[1]] - origin, positions[t[2]] - origin));
  }
  return sum / 6;
}

// A lattice over the box of a shape, and how many of the three lines through each of its points say that it is inside.
class InsideLattice {
 public:
  InsideLattice(std::span<const Vec3d> positions, std::span<const Triangle> triangles, double spacing,
                const std::optional<Box>& within)
      : tree_(triangles, positions), spacing_(spacing) {
    Box box;
    for (const Triangle& t : triangles) {
      for (const std::uint32_t v : t) box.extend(kLatticeTurn * positions[v]);
    }
    const Vec3d first = box.min;
    if (within) box = common(box, turned(*within));
    low_ = box.min;
    for (std::size_t axis = 0; axis < 3; ++axis) before_[axis] = std::ceil((low_[axis] - first[axis]) / spacing);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      counts_[axis] = static_cast<std::size_t>(std::ceil((box.max[axis] - box.min[axis]) / spacing)) + 1;
    }
    votes_.assign(counts_[0] * counts_[1] * counts_[2], 0);
  }

  std::vector<Vec3d> inside(int threads) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t lines = votes_.size() / counts_[axis];
      parallel_for(lines, 64, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t line = begin; line < end; ++line) vote_along(axis, line);
      });
    }
    std::vector<Vec3d> result;
    for (std::size_t i = 0; i < votes_.size(); ++i) {
      if (votes_[i] >= 2) result.push_back(point(i));
    }
    return result;
  }

 private:
  std::size_t stride(std::size_t axis) const {
    return axis == 0 ? 1 : axis == 1 ? counts_[0] : counts_[0] * counts_[1];
  }

  Vec3d point(std::size_t index) const {
    const std::size_t x = index % counts_[0];
    const std::size_t y = index / counts_[0] % counts_[1];
    const std::size_t z = index / counts_[0] / counts_[1];
    const Vec3d steps(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5);
    return transposed(kLatticeTurn) * (low_ + steps * spacing_);
  }

  static Box turned(const Box& box) {
    Box result;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      result.extend(kLatticeTurn * Vec3d{(corner & 1U) != 0 ? box.max.x : box.min.x,
                                         (corner & 2U) != 0 ? box.max.y : box.min.y,
                                         (corner & 4U) != 0 ? box.max.z : box.min.z});
    }
    return result;
  }

  // Returns the common part of the boxes; one point of `box` if there is none.
  static Box common(Box box, const Box& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = std::min(std::max(box.min[axis], other.min[axis]), box.max[axis]);
      box.max[axis] = std::max(std::min(box.max[axis], other.max[axis]), box.min[axis]);
    }
    return box;
  }

  // A line through a closed surface enters as often as it leaves, so the sum of the crossings before a point is its
  // winding number.
  void vote_along(std::size_t axis, std::size_t line) {
    const std::size_t step = stride(axis);
    const std::size_t first = line % step + line / step * step * counts_[axis];
    const Vec3d direction = point(step) - point(0);
    const double before = before_[axis] + 1;
    const Vec3d origin = point(first) - direction * before;
    int winding = 0;
    std::size_t next = 0;
    for (const RayHit& hit : tree_.hits(origin, direction)) {
      for (; next < counts_[axis] && static_cast<double>(next) + before < hit.t; ++next) {
        if (winding != 0) ++votes_[first + next * step];
      }
      winding += hit.leaves ? -1 : 1;
    }
  }

  SurfaceTree tree_;
  double spacing_;
  Vec3d low_;
  Vec3d before_;  // the number of spacings from the box of the surface to this lattice, along each axis
  std::array<std::size_t, 3> counts_{};
  std::vector<std::uint8_t> votes_;
};

// The vertices of the triangles, and points within those that are larger than the spacing.
std::vector<Vec3d> surface_points(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                  double spacing) {
  std::vector<Vec3d> result;
  std::vector<bool> is_used(positions.size());
  for (const Triangle& t : triangles) {
    const Vec3d& a = positions[t[0]];
    const Vec3d ab = positions[t[1]] - a;
    const Vec3d ac = positions[t[2]] - a;
    for (const std::uint32_t v : t) is_used[v] = true;
    const double longest = std::sqrt(std::max({norm2(ab), norm2(ac), norm2(ac - ab)}));
    const auto pieces = static_cast<std::size_t>(std::min(longest / spacing + 1, double{kMaxEdgeSamples}));
    for (std::size_t i = 0; i <= pieces && pieces > 1; ++i) {
      for (std::size_t j = 0; i + j <= pieces; ++j) {
        result.push_back(a + (ab * static_cast<double>(i) + ac * static_cast<double>(j)) / static_cast<double>(pieces));
      }
    }
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (is_used[v]) result.push_back(positions[v]);
  }
  return result;
}

double area_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  double sum = 0;
  for (const Triangle& t : triangles) {
    sum += norm(cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]));
  }
  return sum / 2;
}

// Returns the points of an open surface or a cloud, and of the layer below the surface.
BodyPoints shell_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                    const BodyPointsOptions& options) {
  BodyPoints result;
  result.is_closed = false;
  std::vector<Vec3d> normals = area_weighted_normals(positions, triangles);
  // If no triangle has an area, the points are a cloud.
  const bool has_surface = std::any_of(normals.begin(), normals.end(), [](const Vec3d& n) { return n != Vec3d{}; });
  std::vector<Vec3d> used;
  std::vector<Vec3d> used_normals;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (has_surface && normals[v] == Vec3d{}) continue;
    used.push_back(positions[v]);
    used_normals.push_back(normals[v]);
  }
  for (const std::uint32_t i : spread_points(used, options.inside)) {
    result.points.push_back(used[i]);
    if (used_normals[i] != Vec3d{}) {
      result.points.push_back(used[i] - used_normals[i] * (options.shell_depth / norm(used_normals[i])));
    }
  }
  return result;
}

bool is_before(const Vec3d& a, const Vec3d& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

Box box_of(std::span<const Vec3d> points) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  return box;
}

struct BoxLattice {
  Vec3d low;
  double spacing = 1;

  std::uint64_t cell(const Vec3d& p) const {
    const auto along = [&](std::size_t axis) { return static_cast<std::uint64_t>((p[axis] - low[axis]) / spacing); };
    return along(0) | along(1) << 21U | along(2) << 42U;
  }
  double square_to_middle(const Vec3d& p) const {
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = (p[axis] - low[axis]) / spacing;
      const double off = at - std::floor(at) - 0.5;
      sum += off * off;
    }
    return sum;
  }
};

// Returns the point of each cell that is nearest to its centre, in the order of the cells; nothing for more than
// `max_cells` cells.
std::vector<std::uint32_t> one_of_each_cell(std::span<const Vec3d> points, const Box& box, double spacing,
                                            std::size_t max_cells) {
  const BoxLattice lattice{box.min, spacing};
  std::unordered_map<std::uint64_t, std::uint32_t> best;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto [found, is_new] = best.try_emplace(lattice.cell(points[i]), i);
    if (best.size() > max_cells) return {};
    if (is_new) continue;
    const double own = lattice.square_to_middle(points[i]);
    const double other = lattice.square_to_middle(points[found->second]);
    if (own < other || (own == other && is_before(points[i], points[found->second]))) found->second = i;
  }
  std::vector<std::pair<std::uint64_t, std::uint32_t>> sorted(best.begin(), best.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> chosen;
  chosen.reserve(sorted.size());
  for (const auto& [cell, i] : sorted) chosen.push_back(i);
  return chosen;
}

std::vector<Triangle> triangles_near(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                     const Box& within) {
  std::vector<Triangle> result;
  for (const Triangle& t : triangles) {
    Box box;
    for (const std::uint32_t v : t) box.extend(positions[v]);
    if (overlap(box, within)) result.push_back(t);
  }
  return result;
}

BodyPoints points_within(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                         const BodyPointsOptions& options) {
  BodyPoints result;
  std::vector<Vec3d> on_surface;
  if (triangles.empty()) {
    std::copy_if(positions.begin(), positions.end(), std::back_inserter(on_surface),
                 [&](const Vec3d& p) { return contains(*options.within, p); });
  } else {
    result.points = InsideLattice(positions, triangles, options.most_spacing, options.within).inside(options.threads);
    result.inside = result.points.size();
    on_surface = surface_points(positions, triangles_near(positions, triangles, *options.within), options.most_spacing);
  }
  for (const std::uint32_t i : points_apart(on_surface, options.most_spacing)) result.points.push_back(on_surface[i]);
  return result;
}

}  // namespace

BodyPoints body_points(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                       const BodyPointsOptions& options) {
  if (options.within) return points_within(positions, triangles, options);
  if (triangles.empty()) return shell_of(positions, triangles, options);
  Box box;
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) box.extend(positions[v]);
  }
  const double volume = std::abs(signed_volume(positions, triangles, box.center()));
  double spacing = cube_edge(volume / static_cast<double>(options.inside));
  if (options.most_spacing > 0) spacing = std::min(spacing, options.most_spacing);
  const Vec3d extent = box.max - box.min;
  const double steps = norm(extent) / spacing;
  if (!(steps * steps * steps < kMaxLatticePoints)) return shell_of(positions, triangles, options);
  BodyPoints result;
  result.points = InsideLattice(positions, triangles, spacing, std::nullopt).inside(options.threads);
  result.inside = result.points.size();
  const double found = static_cast<double>(result.inside) * spacing * spacing * spacing;
  if (found < kMinInsideFraction * volume) return shell_of(positions, triangles, options);
  const double area = area_of(positions, triangles);
  double surface_spacing = std::sqrt(3 * area / static_cast<double>(options.inside));
  if (options.most_spacing > 0) surface_spacing = std::min(surface_spacing, options.most_spacing);
  const auto on_surface = static_cast<std::size_t>(area / (surface_spacing * surface_spacing));
  const std::vector<Vec3d> candidates = surface_points(positions, triangles, surface_spacing);
  for (const std::uint32_t i : spread_points(candidates, on_surface)) result.points.push_back(candidates[i]);
  return result;
}

std::vector<std::uint32_t> spread_points(std::span<const Vec3d> points, std::size_t count) {
  std::vector<std::uint32_t> chosen(points.size());
  std::iota(chosen.begin(), chosen.end(), std::uint32_t{0});
  if (points.size() <= count) {
    std::sort(chosen.begin(), chosen.end(),
              [&](std::uint32_t a, std::uint32_t b) { return is_before(points[a], points[b]); });
    return chosen;
  }
  const Box box = box_of(points);
  // A surface crosses about n^2 of n^3 cells; larger cells follow until they are few enough.
  double spacing = norm(box.max - box.min) / (4 * std::sqrt(static_cast<double>(count)));
  for (;; spacing *= 1.15) {
    std::vector<std::uint32_t> found = one_of_each_cell(points, box, spacing, count);
    if (!found.empty()) return found;
  }
}

std::vector<Vec3d> area_weighted_normals(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  std::vector<Vec3d> normals(positions.size());
  for (const Triangle& t : triangles) {
    const Vec3d n = cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
    for (const std::uint32_t v : t) normals[v] += n;
  }
  return normals;
}

std::vector<std::uint32_t> points_apart(std::span<const Vec3d> points, double spacing) {
  return points.empty() ? std::vector<std::uint32_t>{}
                        : one_of_each_cell(points, box_of(points), spacing, points.size());
}

}  // namespace knead
