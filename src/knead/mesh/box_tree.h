// A tree of boxes over triangles that finds the pairs whose boxes overlap (private to this room).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/vec3.h"
#include "knead/mesh/triangulate.h"

namespace knead {

// A box with float coordinates.
struct FloatBox {
  std::array<float, 3> min{};
  std::array<float, 3> max{};

  bool overlaps(const FloatBox& b) const {
    return min[0] <= b.max[0] && b.min[0] <= max[0] && min[1] <= b.max[1] && b.min[1] <= max[1] && min[2] <= b.max[2] &&
           b.min[2] <= max[2];
  }
};

// A complete binary tree of boxes. Each leaf holds up to kLeafSize triangles; leaves are in the order of the Morton
// curve.
class BoxTree {
 public:
  static constexpr std::size_t kLeafSize = 4;

  // Builds the tree over the triangles whose numbers are in `members`. Positions must be finite. The order of the
  // leaves depends on the arguments only.
  BoxTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
          std::span<const std::uint32_t> members);

  std::size_t leaf_count() const { return (entries_.size() + kLeafSize - 1) / kLeafSize; }

  // Calls visit(t, u) for each pair of different members whose boxes overlap, one in this leaf and the other in the
  // same or a later leaf. Calls for all leaves visit each pair once. The boxes of triangles with a common point always
  // overlap.
  template <class Visit>
  void for_each_overlap(std::size_t leaf, Visit visit) const {
    const std::span<const Entry> own = entries_of(leaf);
    for (std::size_t i = 0; i < own.size(); ++i) {
      for (std::size_t j = i + 1; j < own.size(); ++j) visit_overlap(own[i], own[j], visit);
    }
    // The later leaves are below the right siblings of the nodes between this leaf and the root.
    for (std::size_t node = first_leaf_ + leaf; node > 1; node /= 2) {
      if (node % 2 == 0) descend(node + 1, leaf, visit);
    }
  }

 private:
  struct Entry {
    FloatBox box;
    std::uint32_t triangle = 0;
  };

  std::span<const Entry> entries_of(std::size_t leaf) const {
    const std::size_t begin = leaf * kLeafSize;
    return std::span(entries_).subspan(begin, std::min(kLeafSize, entries_.size() - begin));
  }

  template <class Visit>
  static void visit_overlap(const Entry& a, const Entry& b, Visit& visit) {
    if (a.box.overlaps(b.box)) visit(a.triangle, b.triangle);
  }

  template <class Visit>
  void descend(std::size_t top, std::size_t leaf, Visit& visit) const {
    const FloatBox& box = nodes_[first_leaf_ + leaf];
    std::array<std::size_t, 64> stack{top};
    for (std::size_t height = 1; height > 0;) {
      const std::size_t node = stack[--height];
      if (!nodes_[node].overlaps(box)) continue;
      if (node < first_leaf_) {
        stack[height++] = 2 * node + 1;
        stack[height++] = 2 * node;
        continue;
      }
      for (const Entry& other : entries_of(node - first_leaf_)) {
        if (!other.box.overlaps(box)) continue;
        for (const Entry& own : entries_of(leaf)) visit_overlap(own, other, visit);
      }
    }
  }

  std::vector<Entry> entries_;
  std::size_t first_leaf_ = 1;   // a power of two
  std::vector<FloatBox> nodes_;  // node i has the children 2 i and 2 i + 1; the root is 1
};

}  // namespace knead
