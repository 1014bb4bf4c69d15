#include "knead/mesh/box_tree.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace knead {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr FloatBox kEmpty{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

// The place of a box's centre on the Morton curve.
std::uint64_t morton_code_of(const FloatBox& box) {
  std::array<float, 3> center{};
  for (std::size_t k = 0; k < 3; ++k) center[k] = (box.min[k] + box.max[k]) * 0.5F;
  return morton_code(center);
}

Box bounds_of(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
              std::span<const std::uint32_t> members) {
  Box all;
  for (const std::uint32_t t : members) {
    for (const std::uint32_t v : triangles[t]) all.extend(positions[v]);
  }
  return members.empty() ? Box{{}, {}} : all;
}

}  // namespace

FloatBox BoxTree::box_of(const std::array<Vec3d, 3>& corners) const {
  FloatBox box = kEmpty;
  for (const Vec3d& corner : corners) {
    const std::array<float, 3> p = to_unit_(corner);
    box = join(box, {p, p});
  }
  return box;
}

void BoxTree::widen(std::uint32_t place, const FloatBox& box) {
  Leaf& leaf = leaves_[place / kLeafSize];
  const std::size_t i = place % kLeafSize;
  const FloatBox widened = join(box_in(leaf, i), box);
  for (std::size_t k = 0; k < 3; ++k) {
    leaf.min[k][i] = widened.min[k];
    leaf.max[k][i] = widened.max[k];
  }
  for (std::size_t node = nodes_.size() / 2 + place / kLeafSize; node > 0 && !nodes_[node].holds(box); node /= 2) {
    nodes_[node] = join(nodes_[node], box);
  }
}

BoxTree::BoxTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                 std::span<const std::uint32_t> members)
    : to_unit_(bounds_of(triangles, positions, members)) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(members.size());
  for (const std::uint32_t t : members) order.emplace_back(morton_code_of(box_of(triangles[t], positions)), t);
  std::sort(order.begin(), order.end());

  const std::size_t leaves = std::bit_ceil(std::max<std::size_t>(1, (order.size() + kLeafSize - 1) / kLeafSize));
  leaves_.resize(leaves);
  nodes_.assign(2 * leaves, kEmpty);
  for (std::size_t i = 0; i < leaves * kLeafSize; ++i) {
    Leaf& leaf = leaves_[i / kLeafSize];
    const FloatBox box = i < order.size() ? box_of(triangles[order[i].second], positions) : kEmpty;
    for (std::size_t k = 0; k < 3; ++k) {
      leaf.min[k][i % kLeafSize] = box.min[k];
      leaf.max[k][i % kLeafSize] = box.max[k];
    }
    leaf.triangle[i % kLeafSize] = i < order.size() ? order[i].second : 0;
    nodes_[leaves + i / kLeafSize] = join(nodes_[leaves + i / kLeafSize], box);
  }
  for (std::size_t node = leaves - 1; node > 0; --node) nodes_[node] = join(nodes_[2 * node], nodes_[2 * node + 1]);
}

}  // namespace knead
