#include "knead/mesh/box_tree.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "knead/math/box.h"

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

// Maps the triangles' box into -1 to 1. Every rounding on the way keeps the order of coordinates, so boxes that
// overlap still do.
class ToUnit {
 public:
  explicit ToUnit(const Box& box) : center_(box.center()) {
    const Vec3d half = (box.max - box.min) * 0.5;
    const double largest = std::max({half.x, half.y, half.z});
    if (largest > 0) scale_ = 1 / largest;
  }

  std::array<float, 3> operator()(const Vec3d& p) const {
    const Vec3d q = (p - center_) * scale_;
    return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }

 private:
  Vec3d center_;
  double scale_ = 1;
};

// Puts two zero bits in front of each of the lowest 21 bits.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// The place of a box's centre on the Morton curve.
std::uint64_t morton_code(const FloatBox& box) {
  std::uint64_t code = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    constexpr float cells = 1 << 21;
    const float place = ((box.min[k] + box.max[k]) * 0.25F + 0.5F) * cells;
    code = code << 1 | spread(static_cast<std::uint64_t>(std::clamp(place, 0.0F, cells - 1)));
  }
  return code;
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
    order.emplace_back(morton_code(boxes[t]), t);
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
