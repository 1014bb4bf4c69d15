// A tree of boxes over triangles that finds the pairs whose boxes overlap (private to this module).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/geometry.h"

namespace knead {

// A box with float coordinates.
struct FloatBox {
  std::array<float, 3> min{};
  std::array<float, 3> max{};

  // Without branches, which nobody could predict.
  bool overlaps(const FloatBox& b) const {
    bool all = true;
    for (std::size_t k = 0; k < 3; ++k) {
      all &= min[k] <= b.max[k];
      all &= b.min[k] <= max[k];
    }
    return all;
  }

  bool holds(const FloatBox& b) const {
    bool all = true;
    for (std::size_t k = 0; k < 3; ++k) {
      all &= min[k] <= b.min[k];
      all &= b.max[k] <= max[k];
    }
    return all;
  }
};

inline FloatBox join(const FloatBox& a, const FloatBox& b) {
  FloatBox box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.min[k] = std::min(a.min[k], b.min[k]);
    box.max[k] = std::max(a.max[k], b.max[k]);
  }
  return box;
}

// A complete binary tree of boxes. Each leaf holds up to kLeafSize triangles; leaves are in the order of the Morton
// curve. Its pairs are found in parts, so that several threads can share the work.
class BoxTree {
 public:
  static constexpr std::size_t kLeafSize = 4;

  // Builds the tree over the triangles whose numbers are in `members`. Positions must be finite. The order of the
  // leaves depends on these only. threads as for parallel_for.
  BoxTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions, std::span<const std::uint32_t> members,
          int threads);

  std::size_t part_count() const { return nodes_.size() / 2 / leaves_in_part(); }

  // Calls visit(t, u) for each pair of different members whose boxes overlap, one in this part and the other in the
  // same or a later one, until visit returns false. Calls for all parts visit each pair once. The boxes of triangles
  // with a common point always overlap.
  template <class Visit>
  void for_each_overlap(std::size_t part, Visit visit) const {
    const std::size_t root = part_count() + part;
    if (!visit_within(root, visit)) return;
    // The later parts are below the right siblings of the nodes between this part and the root.
    for (std::size_t node = root; node > 1; node /= 2) {
      if (node % 2 == 0 && !visit_between(root, node + 1, visit)) return;
    }
  }

  FloatBox box_of(const std::array<Vec3d, 3>& corners) const;

  // Calls visit(u) for each member whose box overlaps the given one, until visit returns false.
  template <class Visit>
  void for_each_overlap_with(const FloatBox& box, Visit visit) const {
    for_each_place_with(box, [&](std::uint32_t place) { return visit(member_at(place)); });
  }

  // The same with the places of the members in the tree, which are numbered from 0 and near each other in space.
  template <class Visit>
  void for_each_place_with(const FloatBox& box, Visit visit) const {
    visit_below(1, box, visit);
  }

  std::uint32_t member_at(std::uint32_t place) const { return leaves_[place / kLeafSize].triangle[place % kLeafSize]; }
  // Widens the box of the member at a place, and all boxes around it, so that they hold another box.
  void widen(std::uint32_t place, const FloatBox& box);

 private:
  // Boxes side by side; places without a triangle have an empty box.
  struct Leaf {
    using Lanes [[gnu::vector_size(kLeafSize * sizeof(float))]] = float;
    std::array<Lanes, 3> min;
    std::array<Lanes, 3> max;
    std::array<std::uint32_t, kLeafSize> triangle;
  };

  static FloatBox box_in(const Leaf& leaf, std::size_t i) {
    return {{leaf.min[0][i], leaf.min[1][i], leaf.min[2][i]}, {leaf.max[0][i], leaf.max[1][i], leaf.max[2][i]}};
  }

  FloatBox box_of(const Triangle& t, std::span<const Vec3d> positions) const {
    return box_of({positions[t[0]], positions[t[1]], positions[t[2]]});
  }
  std::size_t leaves_in_part() const { return std::min<std::size_t>(nodes_.size() / 2, 256); }
  bool is_leaf(std::size_t node) const { return node >= nodes_.size() / 2; }
  const Leaf& leaf_of(std::size_t node) const { return leaves_[node - nodes_.size() / 2]; }

  // Calls visit(i) for the places from `first` on whose boxes overlap.
  template <class Visit>
  static bool visit_leaf(const Leaf& leaf, const FloatBox& box, std::size_t first, Visit visit) {
    auto hit = (leaf.min[0] <= box.max[0]) & (leaf.max[0] >= box.min[0]);
    for (std::size_t k = 1; k < 3; ++k) hit &= (leaf.min[k] <= box.max[k]) & (leaf.max[k] >= box.min[k]);
    for (std::size_t i = first; i < kLeafSize; ++i) {
      if (hit[i] != 0 && !visit(i)) return false;
    }
    return true;
  }

  template <class Visit>
  bool visit_below(std::size_t node, const FloatBox& box, Visit& visit) const {
    if (!nodes_[node].overlaps(box)) return true;
    if (!is_leaf(node)) return visit_below(2 * node, box, visit) && visit_below(2 * node + 1, box, visit);
    const std::size_t first = kLeafSize * (node - nodes_.size() / 2);
    return visit_leaf(leaf_of(node), box, 0,
                      [&](std::size_t i) { return visit(static_cast<std::uint32_t>(first + i)); });
  }

  template <class Visit>
  bool visit_within(std::size_t node, Visit& visit) const {
    if (!is_leaf(node)) {
      return visit_within(2 * node, visit) && visit_within(2 * node + 1, visit) &&
             visit_between(2 * node, 2 * node + 1, visit);
    }
    const Leaf& leaf = leaf_of(node);
    for (std::size_t i = 0; i + 1 < kLeafSize; ++i) {
      const auto visit_pair = [&](std::size_t j) { return visit(leaf.triangle[i], leaf.triangle[j]); };
      if (!visit_leaf(leaf, box_in(leaf, i), i + 1, visit_pair)) return false;
    }
    return true;
  }

  // `a` is as deep in the tree as `b`, or deeper.
  template <class Visit>
  bool visit_between(std::size_t a, std::size_t b, Visit& visit) const {
    if (!nodes_[a].overlaps(nodes_[b])) return true;
    if (!is_leaf(b)) {
      const bool is_deeper = std::bit_width(a) > std::bit_width(b);
      if (is_deeper) return visit_between(a, 2 * b, visit) && visit_between(a, 2 * b + 1, visit);
      return visit_between(2 * a, 2 * b, visit) && visit_between(2 * a, 2 * b + 1, visit) &&
             visit_between(2 * a + 1, 2 * b, visit) && visit_between(2 * a + 1, 2 * b + 1, visit);
    }
    const Leaf& own = leaf_of(a);
    const Leaf& other = leaf_of(b);
    for (std::size_t i = 0; i < kLeafSize; ++i) {
      const auto visit_pair = [&](std::size_t j) { return visit(own.triangle[i], other.triangle[j]); };
      if (!visit_leaf(other, box_in(own, i), 0, visit_pair)) return false;
    }
    return true;
  }

  ToUnit to_unit_;
  std::vector<Leaf> leaves_;     // as many as a power of two
  std::vector<FloatBox> nodes_;  // node i has the children 2 i and 2 i + 1; the root is 1, the second half are leaves
};

// The point of a triangle nearest to a given point (private to this module).

struct NearTriangle {
  std::array<double, 3> barycentric{};
  Vec3d point;
  double distance2 = 0;
};

// Returns the point of the triangle nearest to p, for any triangle. Its distance is below the true one by rounding
// errors at most. It may be above the true one if rounding decides between the interior and an edge.
NearTriangle nearest_on_triangle(const std::array<Vec3d, 3>& corners, const Vec3d& p);

}  // namespace knead
