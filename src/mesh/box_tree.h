// A tree of boxes over triangles that finds the pairs whose boxes overlap, and the nearest points of triangles.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/geometry.h"

namespace knead {

using FloatLanes [[gnu::vector_size(4 * sizeof(float))]] = float;

// Returns true if a comparison holds for all lanes.
using TwoWords [[gnu::vector_size(4 * sizeof(float))]] = std::uint64_t;
template <class Lanes>
bool has_all_bits(const Lanes& lanes) {
  const auto words = reinterpret_cast<TwoWords>(lanes);
  return (words[0] & words[1]) == ~std::uint64_t{0};
}
// Returns true if a comparison holds for no lane.
template <class Lanes>
bool has_no_bits(const Lanes& lanes) {
  const auto words = reinterpret_cast<TwoWords>(lanes);
  return (words[0] | words[1]) == 0;
}

// Returns the positions of the corners of a triangle.
inline std::array<Vec3d, 3> corners_of(const Triangle& t, std::span<const Vec3d> positions) {
  return {positions[t[0]], positions[t[1]], positions[t[2]]};
}

// A box with float coordinates; the fourth lane is 0.
struct FloatBox {
  FloatLanes min{};
  FloatLanes max{};

  bool overlaps(const FloatBox& b) const { return has_all_bits((min <= b.max) & (b.min <= max)); }
  bool holds(const FloatBox& b) const { return has_all_bits((min <= b.min) & (b.max <= max)); }
};

inline FloatBox join(const FloatBox& a, const FloatBox& b) {
  return {b.min < a.min ? b.min : a.min, a.max < b.max ? b.max : a.max};
}

// A complete binary tree of boxes. Each leaf holds up to kLeafSize triangles; leaves are in the order of the Morton
// curve. A search for pairs consists of parts, which several threads can share.
class BoxTree {
 public:
  static constexpr std::size_t kLeafSize = 4;

  // Builds the tree over the triangles whose numbers are in `members`. Positions must be finite. The order of the
  // leaves depends on the members and their positions only. threads as for parallel_for.
  BoxTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions, std::span<const std::uint32_t> members,
          int threads);

  std::size_t part_count() const { return nodes_.size() / 2 / leaves_in_part(); }

  // Gives each member three names, some of which may be kNoName. for_each_overlap() then leaves out the pairs with a
  // name in common.
  static constexpr std::uint32_t kNoName = 0xffffffff;
  template <class NamesOf>
  void set_names(const NamesOf& names_of, int threads) {
    names_.resize(leaves_.size());
    parallel_for(leaves_.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t leaf = begin; leaf < end; ++leaf) {
        for (std::size_t i = 0; i < kLeafSize && kLeafSize * leaf + i < size_; ++i) {
          const std::array<std::uint32_t, 3> names = names_of(leaves_[leaf].triangle[i]);
          for (std::size_t k = 0; k < 3; ++k) names_[leaf][k][i] = names[k];
        }
      }
    });
  }

  // Calls visit(t, u) for each pair of different members whose boxes overlap, one in this part and the other in the
  // same or a later one, until visit returns false. Calls for all parts visit each pair once. The boxes of triangles
  // with a common point always overlap.
  template <class Visit>
  void for_each_overlap(std::size_t part, Visit visit) const {
    const std::size_t root = part_count() + part;
    if (!visit_within(root, visit)) return;
    // The later parts are below the right siblings of the nodes between this part and the root.
    for (std::size_t node = root; node > 1; node /= 2) {
      if (node % 2 == 0 && !visit_overlap(root, node + 1, visit)) return;
    }
  }

  FloatBox box_of(const std::array<Vec3d, 3>& corners) const;

  // Calls visit(u) for each member whose box overlaps the given one, until visit returns false.
  template <class Visit>
  void for_each_overlap_with(const FloatBox& box, Visit visit) const {
    for_each_place_with(box, [&](std::uint32_t place) { return visit(member_at(place)); });
  }

  // Does this with the places of the members in the tree: numbers from 0; members with near numbers are near in space.
  template <class Visit>
  void for_each_place_with(const FloatBox& box, Visit visit) const {
    for_each_leaf_with(box, [&](std::size_t leaf) {
      return visit_hits(overlaps(leaves_[leaf], box), 0,
                        [&](std::size_t i) { return visit(static_cast<std::uint32_t>(kLeafSize * leaf + i)); });
    });
  }

  // Calls visit(leaf) for each leaf whose box overlaps the given one, until visit returns false.
  template <class Visit>
  void for_each_leaf_with(const FloatBox& box, Visit visit) const {
    visit_below(1, box, visit);
  }
  // Calls visit(u) for each member of the leaf whose box overlaps the given one.
  template <class Visit>
  void for_each_overlap_in(std::size_t leaf, const FloatBox& box, Visit visit) const {
    visit_hits(overlaps(leaves_[leaf], box), 0, [&](std::size_t i) {
      visit(leaves_[leaf].triangle[i]);
      return true;
    });
  }

  std::uint32_t member_at(std::uint32_t place) const { return leaves_[place / kLeafSize].triangle[place % kLeafSize]; }
  // Widens the box of the member at a place, and all boxes around it, so that they hold another box.
  void widen(std::uint32_t place, const FloatBox& box);

 private:
  static constexpr std::size_t kGrain = 4096;  // triangles, or leaves
  using Names [[gnu::vector_size(kLeafSize * sizeof(float))]] = std::uint32_t;
  static_assert(sizeof(Names) == sizeof(FloatLanes));

  // The boxes of its members, a lane each; places without a member have an empty box.
  struct Leaf {
    std::array<FloatLanes, 3> min;
    std::array<FloatLanes, 3> max;
    std::array<std::uint32_t, kLeafSize> triangle;
  };

  static FloatBox box_in(const Leaf& leaf, std::size_t i) {
    const FloatLanes min{leaf.min[0][i], leaf.min[1][i], leaf.min[2][i]};
    const FloatLanes max{leaf.max[0][i], leaf.max[1][i], leaf.max[2][i]};
    return {min, max};
  }

  FloatBox box_of(const Triangle& t, std::span<const Vec3d> positions) const {
    return box_of(corners_of(t, positions));
  }
  std::size_t leaves_in_part() const { return std::min<std::size_t>(nodes_.size() / 2, 256); }
  bool is_leaf(std::size_t node) const { return node >= nodes_.size() / 2; }
  std::size_t leaf_of(std::size_t node) const { return node - nodes_.size() / 2; }

  // Returns all bits set for the places whose boxes overlap.
  static Names overlaps(const Leaf& leaf, const FloatBox& box) {
    auto hit = (leaf.min[0] <= box.max[0]) & (leaf.max[0] >= box.min[0]);
    for (std::size_t k = 1; k < 3; ++k) hit &= (leaf.min[k] <= box.max[k]) & (leaf.max[k] >= box.min[k]);
    return reinterpret_cast<Names>(hit);
  }

  // Calls visit(i) for the places from `first` on that have bits, until it returns false; returns false then.
  template <class Visit>
  static bool visit_hits(const Names& hits, std::size_t first, const Visit& visit) {
    if (has_no_bits(hits)) return true;
    for (std::size_t i = first; i < kLeafSize; ++i) {
      if (hits[i] != 0 && !visit(i)) return false;
    }
    return true;
  }

  // Calls visit(t, u) for the member t at place i of leaf `own` and each member u of leaf `other`, from the place
  // `first` on, whose box overlaps that of t and which has no name in common with t.
  template <class Visit>
  bool visit_pairs(std::size_t own, std::size_t i, std::size_t other, std::size_t first, Visit& visit) const {
    Names hits = overlaps(leaves_[other], box_in(leaves_[own], i));
    if (!names_.empty()) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t name = names_[own][k][i];
        if (name == kNoName) continue;
        for (const Names& names : names_[other]) hits &= reinterpret_cast<Names>(names != name);
      }
    }
    return visit_hits(hits, first,
                      [&](std::size_t j) { return visit(leaves_[own].triangle[i], leaves_[other].triangle[j]); });
  }

  template <class Visit>
  bool visit_below(std::size_t node, const FloatBox& box, Visit& visit) const {
    if (!nodes_[node].overlaps(box)) return true;
    if (!is_leaf(node)) return visit_below(2 * node, box, visit) && visit_below(2 * node + 1, box, visit);
    return visit(leaf_of(node));
  }

  template <class Visit>
  bool visit_within(std::size_t node, Visit& visit) const {
    if (!is_leaf(node)) {
      return visit_within(2 * node, visit) && visit_within(2 * node + 1, visit) &&
             visit_overlap(2 * node, 2 * node + 1, visit);
    }
    const std::size_t leaf = leaf_of(node);
    for (std::size_t i = 0; i + 1 < kLeafSize; ++i) {
      if (!visit_pairs(leaf, i, leaf, i + 1, visit)) return false;
    }
    return true;
  }

  // `a` is as deep in the tree as `b`, or deeper.
  template <class Visit>
  bool visit_overlap(std::size_t a, std::size_t b, Visit& visit) const {
    return !nodes_[a].overlaps(nodes_[b]) || visit_between(a, b, visit);
  }

  // The boxes of a and b overlap.
  template <class Visit>
  bool visit_between(std::size_t a, std::size_t b, Visit& visit) const {
    if (!is_leaf(b)) {
      const bool is_deeper = std::bit_width(a) > std::bit_width(b);
      if (is_deeper) return visit_overlap(a, 2 * b, visit) && visit_overlap(a, 2 * b + 1, visit);
      return visit_overlap(2 * a, 2 * b, visit) && visit_overlap(2 * a, 2 * b + 1, visit) &&
             visit_overlap(2 * a + 1, 2 * b, visit) && visit_overlap(2 * a + 1, 2 * b + 1, visit);
    }
    for (std::size_t i = 0; i < kLeafSize; ++i) {
      if (!visit_pairs(leaf_of(a), i, leaf_of(b), 0, visit)) return false;
    }
    return true;
  }

  ToUnit to_unit_;
  std::size_t size_;                         // the number of members
  std::vector<Leaf> leaves_;                 // a power of two
  std::vector<std::array<Names, 3>> names_;  // of the members of each leaf; empty: there are none
  std::vector<FloatBox> nodes_;  // node i has the children 2 i and 2 i + 1; the root is 1, the second half are leaves
};

// The point of a triangle that is nearest to a given point.
struct NearTriangle {
  std::array<double, 3> barycentric{};
  Vec3d point;
  double distance2 = 0;
};

// Returns the point of the triangle, which may be degenerate, that is nearest to p. Its distance is below the true one
// by rounding errors at most. It may be above the true one where rounding decides between the interior and an edge.
NearTriangle nearest_on_triangle(const std::array<Vec3d, 3>& corners, const Vec3d& p);

// Returns for each point the nearest point of the surface, as SurfaceTree::closest() does. `guesses`: for each point a
// triangle that is probably near. Searches around the guesses for many neighbouring points at once, which takes far
// less time than a search for each. Throws Cancelled.
std::vector<Vec3d> nearest_points(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                  std::span<const Vec3d> points, std::span<const std::uint32_t> guesses, int threads,
                                  const Progress* progress);

}  // namespace knead
