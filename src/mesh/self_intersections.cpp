// Finds the pairs of triangles in which a surface intersects itself: boxes first, then exact predicates.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/box_tree.h"
#include "mesh/predicates.h"

namespace knead {
namespace {

using Pair = std::array<std::uint32_t, 2>;

// Returns the positions times a power of two: the largest coordinate in use is then from 1 to 2, as predicates.h
// requires.
std::vector<Vec3d> scale_to_range(std::span<const Triangle> triangles, std::span<const Vec3d> positions) {
  double largest = 0;
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) {
      const Vec3d& p = positions[v];
      largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
  }
  const int exponent = largest > 0 ? std::ilogb(largest) : 0;
  const double part = std::scalbn(1.0, -exponent / 2);  // in two parts neither overflows
  const double rest = std::scalbn(1.0, -exponent - -exponent / 2);
  const auto scaled = [&](double x) {
    const double y = x * part * rest;
    return std::abs(y) < 0x1p-250 ? 0.0 : y;
  };
  std::vector<Vec3d> result(positions.size());
  std::transform(positions.begin(), positions.end(), result.begin(), [&](const Vec3d& p) {
    return Vec3d{scaled(p.x), scaled(p.y), scaled(p.z)};
  });
  return result;
}

// The pairs that each chunk of work finds, up to a common limit.
class FoundPairs {
 public:
  FoundPairs(std::size_t chunks, std::size_t limit) : pairs_of_(chunks), limit_(limit) {}

  bool full() const { return count_.load(std::memory_order_relaxed) > limit_; }

  void add(std::size_t chunk, const Pair& pair) {
    pairs_of_[chunk].push_back(pair);
    count_.fetch_add(1, std::memory_order_relaxed);
  }

  SelfIntersections sorted(std::size_t triangles) const {
    if (full()) return {{}, limit_, false};
    SelfIntersections result;
    result.count = count_;
    if (result.count < triangles) {
      for (const std::vector<Pair>& pairs : pairs_of_) {
        result.pairs.insert(result.pairs.end(), pairs.begin(), pairs.end());
      }
      std::sort(result.pairs.begin(), result.pairs.end());
    } else {
      sort_many(triangles, result.pairs);
    }
    return result;
  }

 private:
  // Distributes the pairs by their first triangle, then sorts the pairs of each triangle.
  void sort_many(std::size_t triangles, std::vector<Pair>& sorted) const {
    std::vector<std::size_t> end(triangles + 1, 0);  // of the pairs of each triangle in `sorted`
    for (const std::vector<Pair>& pairs : pairs_of_) {
      for (const Pair& pair : pairs) ++end[pair[0] + 1];
    }
    std::partial_sum(end.begin(), end.end(), end.begin());
    sorted.resize(count_);
    for (const std::vector<Pair>& pairs : pairs_of_) {
      for (const Pair& pair : pairs) sorted[end[pair[0]]++] = pair;
    }
    std::size_t begin = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
      const auto first = sorted.begin();
      std::sort(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(end[t]));
      begin = end[t];
    }
  }

  std::vector<std::vector<Pair>> pairs_of_;
  std::size_t limit_;
  std::atomic<std::size_t> count_ = 0;
};

bool is_chosen(std::uint32_t t, const SelfIntersectionOptions& options) {
  return options.chosen == nullptr || (*options.chosen)[t];
}

// Finds the flat vertices: seen along a coordinate axis, the triangles at one surround it once and do not overlap. Two
// triangles at a flat vertex are no pair: they meet only in what they share. Most vertices of most shapes are flat.
class FlatVertices {
 public:
  // Looks at the vertices of the chosen triangles.
  FlatVertices(std::span<const Triangle> triangles, std::span<const Vec3d> points,
               const SelfIntersectionOptions& options)
      : triangles_(triangles), points_(points), begin_(points.size() + 1), flat_(points.size()) {
    std::vector<std::uint8_t> wanted(points.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      if (!is_chosen(t, options)) continue;
      for (const std::uint32_t v : triangles[t]) wanted[v] = 1;
    }
    std::vector<std::uint32_t> found;  // the triangles at them
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      const Triangle& corners = triangles[t];
      if ((wanted[corners[0]] | wanted[corners[1]] | wanted[corners[2]]) != 0) found.push_back(t);
    }
    const auto for_each_corner = [&](const auto& visit) {
      for (const std::uint32_t t : found) {
        for (std::uint32_t i = 0; i < 3; ++i) {
          if (wanted[triangles[t][i]] != 0) visit(3 * t + i, triangles[t][i]);
        }
      }
    };
    for_each_corner([&](std::uint32_t, std::uint32_t v) { ++begin_[v + std::size_t{1}]; });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    corners_.resize(begin_.back());
    std::vector<std::uint32_t> end(begin_.begin(), begin_.end() - 1);
    for_each_corner([&](std::uint32_t c, std::uint32_t v) { corners_[end[v]++] = c; });
    parallel_for(points.size(), 4096, options.threads, [&](std::size_t first, std::size_t last) {
      stop_if_cancelled(options.progress);
      for (std::size_t v = first; v < last; ++v) flat_[v] = is_flat(static_cast<std::uint32_t>(v)) ? 1 : 0;
    });
  }

  bool is_any(const Triangle& t) const { return flat_[t[0]] + flat_[t[1]] + flat_[t[2]] > 0; }

  // Returns the corners that are flat; kNoName for the others.
  std::array<std::uint32_t, 3> of(const Triangle& t) const {
    const auto name = [&](std::uint32_t v) { return flat_[v] != 0 ? v : BoxTree::kNoName; };
    return {name(t[0]), name(t[1]), name(t[2])};
  }

  bool is_shared(const Triangle& t, const Triangle& u) const {
    return std::any_of(t.begin(), t.end(),
                       [&](std::uint32_t v) { return flat_[v] != 0 && (v == u[0] || v == u[1] || v == u[2]); });
  }

 private:
  static constexpr std::size_t kMaxTriangles = 32;  // a vertex with more does not count as flat

  // Goes around the vertex from triangle to triangle; all must have the same orientation. Each full turn crosses a line
  // through the vertex once in each direction.
  bool is_flat(std::uint32_t v) const {
    const std::size_t count = begin_[v + std::size_t{1}] - begin_[v];
    if (count < 3 || count > kMaxTriangles) return false;
    std::array<std::array<std::uint32_t, 2>, kMaxTriangles> sides{};  // the other corners of each triangle
    Vec3d normal{};
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t c = corners_[begin_[v] + i];
      const Triangle& t = triangles_[c / 3];
      sides[i] = {t[(c + 1) % 3], t[(c + 2) % 3]};
      normal += cross(points_[sides[i][0]] - points_[v], points_[sides[i][1]] - points_[v]);
    }
    const int axis = widest_axis(normal);
    const int turn = normal[static_cast<std::size_t>(axis)] > 0 ? 1 : -1;
    const std::size_t height = axis == 2 ? 0 : static_cast<std::size_t>(axis) + 1;
    const auto is_below = [&](std::uint32_t w) { return points_[w][height] < points_[v][height]; };
    std::size_t at = 0;
    int rises = 0;
    for (std::size_t step = 1; step <= count; ++step) {
      const auto [from, to] = sides[at];
      if (orient2d(points_[v], points_[from], points_[to], axis) != turn) return false;
      rises += is_below(from) && !is_below(to) ? 1 : 0;
      for (at = 0; at < count && sides[at][0] != to;) ++at;
      const bool is_round = at == 0;  // after exactly `count` steps, each triangle has been met once
      if (at == count || is_round != (step == count)) return false;
    }
    return rises == 1;
  }

  std::span<const Triangle> triangles_;
  std::span<const Vec3d> points_;
  std::vector<std::uint32_t> begin_;    // of each vertex, in corners_
  std::vector<std::uint32_t> corners_;  // 3 t + i: corner i of triangle t
  std::vector<std::uint8_t> flat_;
};

struct SortedTriangles {
  std::vector<std::uint32_t> degenerate;  // chosen ones without area
  std::vector<std::uint32_t> chosen;
  std::vector<std::uint32_t> others;
};

SortedTriangles sort_triangles(std::span<const Triangle> triangles, std::span<const Vec3d> points,
                               const FlatVertices& flat, const SelfIntersectionOptions& options) {
  SortedTriangles sorted;
  sorted.chosen.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    stop_if_cancelled(options.progress);
    if (!is_chosen(t, options)) {
      sorted.others.push_back(t);
    } else {
      const bool has_area = flat.is_any(triangles[t]) || !are_collinear(corners_of(triangles[t], points));
      (has_area ? sorted.chosen : sorted.degenerate).push_back(t);
    }
  }
  return sorted;
}

}  // namespace

SelfIntersections self_intersections(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                     const SelfIntersectionOptions& options) {
  check_triangles(triangles, positions);
  const std::vector<Vec3d> points = scale_to_range(triangles, positions);
  const FlatVertices flat(triangles, points, options);
  const SortedTriangles sorted = sort_triangles(triangles, points, flat, options);
  stop_if_cancelled(options.progress);
  BoxTree tree(triangles, points, sorted.chosen, options.threads);
  tree.set_names([&](std::uint32_t t) { return flat.of(triangles[t]); }, options.threads);
  constexpr std::size_t grain = 4096;  // triangles of a chunk
  const std::size_t first_part = 2 + sorted.others.size() / grain;
  FoundPairs findings(first_part + tree.part_count(), options.limit);
  for (const std::uint32_t t : sorted.degenerate) findings.add(0, {t, t});
  // Tests a pair; returns false once the limit is exceeded.
  const auto look_at = [&](std::size_t chunk, std::uint32_t t, std::uint32_t u) {
    const Triangle& a = triangles[t];
    const Triangle& b = triangles[u];
    if (meet_beyond_shared(a, corners_of(a, points), b, corners_of(b, points))) {
      findings.add(chunk, {std::min(t, u), std::max(t, u)});
    }
    return !findings.full();
  };
  parallel_for(sorted.others.size(), grain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !findings.full(); ++i) {
      stop_if_cancelled(options.progress);
      const std::uint32_t t = sorted.others[i];
      const Corners corners = corners_of(triangles[t], points);
      tree.for_each_overlap_with(tree.box_of(corners), [&](std::uint32_t u) {
        if (flat.is_shared(triangles[t], triangles[u])) return true;
        return !are_collinear(corners) && look_at(1 + begin / grain, t, u);  // a triangle without area is in no pair
      });
    }
  });
  parallel_for(tree.part_count(), 1, options.threads, [&](std::size_t part, std::size_t) {
    stop_if_cancelled(options.progress);
    if (findings.full()) return;
    tree.for_each_overlap(part, [&](std::uint32_t t, std::uint32_t u) { return look_at(first_part + part, t, u); });
  });
  return findings.sorted(triangles.size());
}

std::size_t count_new(const SelfIntersections& now, const SelfIntersections& before) {
  if (!now.complete || !before.complete) return now.count;
  return static_cast<std::size_t>(std::count_if(now.pairs.begin(), now.pairs.end(), [&](const auto& pair) {
    return !std::binary_search(before.pairs.begin(), before.pairs.end(), pair);
  }));
}

}  // namespace knead
