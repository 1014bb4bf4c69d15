#include "knead/flow/point_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "knead/flow/kernel.h"
#include "knead/math/error.h"
#include "knead/math/morton.h"

namespace knead {

namespace {

using detail::kBlock;
using detail::kBlocksPerGroup;
using detail::kGroup;

struct Key {
  std::uint64_t code = 0;
  std::uint32_t index = 0;
};

// By the 33 highest bits of 63: two billion cells of the points' box to each of four are enough for blocks.
void sort_by_code(std::vector<Key>& keys) {
  constexpr int kBits = 11;
  std::vector<Key> sorted(keys.size());
  for (const int shift : {30, 30 + kBits, 30 + 2 * kBits}) {
    const auto digit = [&](const Key& key) { return key.code >> shift & ((1 << kBits) - 1); };
    std::array<std::size_t, (1 << kBits) + 1> begin{};
    for (const Key& key : keys) ++begin[digit(key) + 1];
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    for (const Key& key : keys) sorted[begin[digit(key)]++] = key;
    keys.swap(sorted);
  }
}

// Returns point i, and throws InvalidInput unless it is finite.
const Vec3d& finite(std::span<const Vec3d> points, std::size_t i) {
  if (is_finite(points[i])) return points[i];
  throw InvalidInput(fmt::format("point {} has a coordinate that is not finite; place or remove it", i));
}

}  // namespace

void require_finite(std::span<const Vec3d> points) {
  for (std::size_t i = 0; i < points.size(); ++i) finite(points, i);
}

PointBlocks::PointBlocks(std::span<const Vec3d> points, Order order)
    : size_(points.size()), padded_((points.size() + kGroup - 1) / kGroup * kGroup) {
  if (points.size() > 0xffffffffU) throw InvalidInput("there are more than 4 billion points; deform them in parts");
  numbers_.resize(3 * padded_);
  counts_.resize(padded_);
  if (order == Order::sorted) sort(points);
  for (std::size_t i = 0; i < size_; ++i) {
    const Vec3d& point = finite(points, original(i));
    for (std::size_t axis = 0; axis < 3; ++axis) numbers_[axis * padded_ + i] = point[axis];
  }
  blocks_.resize((size_ + kBlock - 1) / kBlock);
  groups_.resize((size_ + kGroup - 1) / kGroup);
  for (std::size_t block = 0; block < blocks_.size(); ++block) fit_block(block);
  for (std::size_t group = 0; group < groups_.size(); ++group) fit_group(group);
}

void PointBlocks::sort(std::span<const Vec3d> points) {
  const Box box = bounding_box(points);
  if (box.empty()) return;
  const ToUnit to_unit(box);
  std::vector<Key> keys(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    keys[i] = {morton_code(to_unit(finite(points, i))), static_cast<std::uint32_t>(i)};
  }
  sort_by_code(keys);
  order_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) order_[i] = keys[i].index;
}

void PointBlocks::fit_block(std::size_t block) {
  const std::size_t first = block * kBlock;
  const std::size_t count = std::min(kBlock, size_ - first);
  Bounds& bounds = blocks_[block];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* const x = numbers_.data() + axis * padded_ + first;
    double low = x[0];
    double high = x[0];
    for (std::size_t i = 1; i < count; ++i) {
      low = x[i] < low ? x[i] : low;
      high = x[i] > high ? x[i] : high;
    }
    bounds.center[axis] = 0.5 * (low + high);
    bounds.half[axis] = 0.5 * (high - low) * (1 + 1e-12);
  }
  bounds.slack = 0;
}

void PointBlocks::fit_group(std::size_t group) {
  Box box;
  const std::size_t first = group * kBlocksPerGroup;
  for (std::size_t block = first; block < std::min(first + kBlocksPerGroup, blocks_.size()); ++block) {
    const Bounds& bounds = blocks_[block];
    const Vec3d reach = bounds.half + Vec3d{1, 1, 1} * bounds.slack;
    box.extend(bounds.center - reach);
    box.extend(bounds.center + reach);
  }
  groups_[group].center = box.center();
  groups_[group].half = (box.max - box.min) * (0.5 * (1 + 1e-12));
}

void PointBlocks::copy_block(std::size_t block, std::span<Vec3d> points) const {
  const std::size_t end = std::min((block + 1) * kBlock, size_);
  const double* const x = coordinates(0);
  const double* const y = coordinates(1);
  const double* const z = coordinates(2);
  for (std::size_t i = block * kBlock; i < end; ++i) points[original(i)] = {x[i], y[i], z[i]};
}

void PointBlocks::copy_to(std::span<Vec3d> points) const {
  if (points.size() != size_)
    throw InvalidInput("the number of points to copy to differs from the number of points in the blocks");
  for (std::size_t block = 0; block < blocks_.size(); ++block) copy_block(block, points);
}

void PointBlocks::update(std::span<Vec3d> points) {
  if (points.size() != size_)
    throw InvalidInput("the number of points to update differs from the number of points in the blocks");
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    if (!groups_[group].has_changed) continue;
    groups_[group].has_changed = false;
    const std::size_t first = group * kBlocksPerGroup;
    for (std::size_t block = first; block < std::min(first + kBlocksPerGroup, blocks_.size()); ++block) {
      if (!blocks_[block].has_changed) continue;
      blocks_[block].has_changed = false;
      copy_block(block, points);
    }
  }
}

std::vector<std::uint32_t> PointBlocks::steps() const {
  std::vector<std::uint32_t> result(size_);
  for (std::size_t i = 0; i < size_; ++i) result[original(i)] = counts_[i];
  return result;
}

}  // namespace knead
