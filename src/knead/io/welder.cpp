#include "knead/io/welder.h"

#include <cstddef>

#include "knead/math/scalar.h"

namespace knead::io_detail {
namespace {

std::uint64_t hash_of(const Vec3d& p) {
  std::uint64_t hash = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    hash ^= bit_cast<std::uint64_t>(p[axis] + 0.0);  // -0 becomes 0
    hash *= 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return hash;
}

constexpr std::uint64_t kHashHalf = 0xffffffff00000000u;

}  // namespace

std::uint32_t Welder::vertex_at(const Vec3d& p) {
  if (2 * positions_.size() >= slots_.size()) grow();
  const std::uint64_t hash = hash_of(p);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t slot = hash & mask;; slot = (slot + 1) & mask) {
    const std::uint32_t vertex = static_cast<std::uint32_t>(slots_[slot]);
    if (slots_[slot] == kEmpty) {
      const std::uint32_t added = static_cast<std::uint32_t>(positions_.size());
      slots_[slot] = (hash & kHashHalf) | added;
      positions_.push_back(p);
      return added;
    }
    if (((slots_[slot] ^ hash) & kHashHalf) == 0 && positions_[vertex] == p) return vertex;
  }
}

void Welder::grow() {
  slots_.assign(4 * slots_.size(), kEmpty);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const std::uint64_t hash = hash_of(positions_[i]);
    std::size_t slot = hash & mask;
    while (slots_[slot] != kEmpty) slot = (slot + 1) & mask;
    slots_[slot] = (hash & kHashHalf) | i;
  }
}

}  // namespace knead::io_detail
