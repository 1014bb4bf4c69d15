#include "knead/mesh/self_intersections.h"

#include <algorithm>
#include <atomic>
#include <cmath>

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

  SelfIntersections sorted() const {
    if (full()) return {{}, limit_, false};
    SelfIntersections result;
    for (const std::vector<Pair>& pairs : pairs_of_) {
      result.pairs.insert(result.pairs.end(), pairs.begin(), pairs.end());
    }
    std::sort(result.pairs.begin(), result.pairs.end());
    result.count = result.pairs.size();
    return result;
  }

 private:
  std::vector<std::vector<Pair>> pairs_of_;
  std::size_t limit_;
  std::atomic<std::size_t> count_ = 0;
};

}  // namespace

SelfIntersections self_intersections(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                     const SelfIntersectionOptions& options) {
  const std::vector<Vec3d> points = scale_to_range(triangles, positions);
  constexpr std::size_t grain = 256;  // leaves
  Findings findings(1 + triangles.size() / (grain * BoxTree::kLeafSize) + 1, options.limit);
  std::vector<std::uint32_t> sound;
  sound.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    stop_if_cancelled(options.progress);
    if (are_collinear(corners_of(triangles[t], points))) {
      findings.add(0, {t, t});
    } else {
      sound.push_back(t);
    }
  }
  stop_if_cancelled(options.progress);
  const BoxTree tree(triangles, points, sound);
  parallel_for(tree.leaf_count(), grain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end && !findings.full(); ++leaf) {
      stop_if_cancelled(options.progress);
      tree.for_each_overlap(leaf, [&](std::uint32_t t, std::uint32_t u) {
        if (findings.full()) return;
        const Triangle& a = triangles[t];
        const Triangle& b = triangles[u];
        if (meet_beyond_shared(a, corners_of(a, points), b, corners_of(b, points))) {
          findings.add(1 + begin / grain, {std::min(t, u), std::max(t, u)});
        }
      });
    }
  });
  return findings.sorted();
}

}  // namespace knead
