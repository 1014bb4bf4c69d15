#include "knead/mesh/self_intersections.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "knead/math/parallel.h"
#include "knead/mesh/box_tree.h"
#include "knead/mesh/triangle_pair.h"

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
  const auto scaled = [&](double x) {
    const double y = std::scalbn(x, -exponent);
    return std::abs(y) < 0x1p-250 ? 0.0 : y;
  };
  std::vector<Vec3d> result(positions.size());
  std::transform(positions.begin(), positions.end(), result.begin(), [&](const Vec3d& p) {
    return Vec3d{scaled(p.x), scaled(p.y), scaled(p.z)};
  });
  return result;
}

Corners corners_of(const Triangle& t, std::span<const Vec3d> positions) {
  return {positions[t[0]], positions[t[1]], positions[t[2]]};
}

// The pairs that each chunk of work finds, up to a common limit.
class Findings {
 public:
  Findings(std::size_t chunks, std::size_t limit) : pairs_of_(chunks), limit_(limit) {}

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
  // Lays the pairs down by their first triangle, then sorts each triangle's own.
  void sort_many(std::size_t triangles, std::vector<Pair>& sorted) const {
    std::vector<std::size_t> end(triangles + 1, 0);  // of the pairs of each triangle, once they lie there
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

struct Sorted {
  std::vector<std::uint32_t> degenerate;  // of the chosen ones; the others are never in a pair
  std::vector<std::uint32_t> chosen;
  std::vector<std::uint32_t> others;
};

Sorted sort_triangles(std::span<const Triangle> triangles, std::span<const Vec3d> points,
                      const SelfIntersectionOptions& options) {
  Sorted sorted;
  sorted.chosen.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    stop_if_cancelled(options.progress);
    const bool chosen = options.chosen == nullptr || (*options.chosen)[t];
    if (!are_collinear(corners_of(triangles[t], points))) {
      (chosen ? sorted.chosen : sorted.others).push_back(t);
    } else if (chosen) {
      sorted.degenerate.push_back(t);
    }
  }
  return sorted;
}

}  // namespace

SelfIntersections self_intersections(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                     const SelfIntersectionOptions& options) {
  check_triangles(triangles, positions);
  const std::vector<Vec3d> points = scale_to_range(triangles, positions);
  const Sorted sorted = sort_triangles(triangles, points, options);
  stop_if_cancelled(options.progress);
  const BoxTree tree(triangles, points, sorted.chosen);
  constexpr std::size_t grain = 4096;  // triangles
  const std::size_t first_part = 2 + sorted.others.size() / grain;
  Findings findings(first_part + tree.part_count(), options.limit);
  for (const std::uint32_t t : sorted.degenerate) findings.add(0, {t, t});
  // Returns whether to go on.
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
      tree.for_each_overlap_with(tree.box_of(corners_of(triangles[t], points)),
                                 [&](std::uint32_t u) { return look_at(1 + begin / grain, t, u); });
    }
  });
  parallel_for(tree.part_count(), 1, options.threads, [&](std::size_t part, std::size_t) {
    stop_if_cancelled(options.progress);
    if (findings.full()) return;
    tree.for_each_overlap(part, [&](std::uint32_t t, std::uint32_t u) { return look_at(first_part + part, t, u); });
  });
  return findings.sorted(triangles.size());
}

}  // namespace knead
