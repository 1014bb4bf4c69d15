#include "knead/mesh/box_tree.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "knead/math/morton.h"

namespace knead {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr FloatBox kEmpty{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

FloatBox join(const FloatBox& a, const FloatBox& b) {
  FloatBox box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.min[k] = std::min(a.min[k], b.min[k]);
    box.max[k] = std::max(a.max[k], b.max[k]);
  }
  return box;
}

// The place of a box's centre on the Morton curve.
std::uint64_t morton_code_of(const FloatBox& box) {
  std::array<float, 3> center{};
  for (std::size_t k = 0; k < 3; ++k) center[k] = (box.min[k] + box.max[k]) * 0.5F;
  return morton_code(center);
}

}  // namespace

BoxTree::BoxTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                 std::span<const std::uint32_t> members) {
  Box all;
  for (const std::uint32_t t : members) {
    for (const std::uint32_t v : triangles[t]) all.extend(positions[v]);
  }
  const ToUnit to_unit(all);
  std::vector<FloatBox> boxes(triangles.size(), kEmpty);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(members.size());
  for (const std::uint32_t t : members) {
    for (const std::uint32_t v : triangles[t]) {
      const std::array<float, 3> p = to_unit(positions[v]);
      boxes[t] = join(boxes[t], {p, p});
    }
    order.emplace_back(morton_code_of(boxes[t]), t);
  }
  std::sort(order.begin(), order.end());
  entries_.reserve(order.size());
  for (const auto& [code, t] : order) entries_.push_back({boxes[t], t});

  first_leaf_ = std::bit_ceil(std::max<std::size_t>(1, leaf_count()));
  nodes_.assign(2 * first_leaf_, kEmpty);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    FloatBox& leaf = nodes_[first_leaf_ + i / kLeafSize];
    leaf = join(leaf, entries_[i].box);
  }
  for (std::size_t node = first_leaf_ - 1; node > 0; --node)
    nodes_[node] = join(nodes_[2 * node], nodes_[2 * node + 1]);
}

}  // namespace knead
