#include "knead/session/deformed_shape.h"

#include <algorithm>
#include <cstring>

#include "knead/math/parallel.h"

namespace knead {

namespace {

constexpr std::size_t kChunksAtOnce = 16;

// To the bit: 0 and -0 differ.
bool are_same(const Vec3d* a, const Vec3d* b, std::size_t count) {
  return std::memcmp(static_cast<const void*>(a), static_cast<const void*>(b), count * sizeof(Vec3d)) == 0;
}

}  // namespace

Snapshot::Snapshot(std::span<const Vec3d> positions, const Snapshot& before, int threads)
    : size_(positions.size()), chunks_((positions.size() + kChunk - 1) / kChunk) {
  const bool may_share = before.size_ == size_;
  parallel_for(chunks_.size(), kChunksAtOnce, threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::size_t count = std::min(kChunk, size_ - i * kChunk);
      const Vec3d* const from = positions.data() + i * kChunk;
      if (may_share && are_same(before.chunks_[i]->data(), from, count)) {
        chunks_[i] = before.chunks_[i];
        continue;
      }
      auto chunk = std::make_shared<Chunk>();
      std::copy(from, from + count, chunk->begin());
      chunks_[i] = std::move(chunk);
    }
  });
}

void Snapshot::copy_to(std::span<Vec3d> positions) const {
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const std::size_t count = std::min(kChunk, size_ - i * kChunk);
    std::copy_n(chunks_[i]->begin(), count, positions.begin() + static_cast<std::ptrdiff_t>(i * kChunk));
  }
}

std::vector<Vec3d> Snapshot::copy() const {
  std::vector<Vec3d> positions(size_);
  copy_to(positions);
  return positions;
}

std::vector<IndexRange> Snapshot::changes_since(const Snapshot& before) const {
  std::vector<IndexRange> ranges;
  const bool comparable = before.size_ == size_;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    if (comparable && chunks_[i] == before.chunks_[i]) continue;
    const auto begin = static_cast<std::uint32_t>(i * kChunk);
    const auto end = static_cast<std::uint32_t>(std::min((i + 1) * kChunk, size_));
    if (!ranges.empty() && ranges.back().end == begin) {
      ranges.back().end = end;
    } else {
      ranges.push_back({begin, end});
    }
  }
  return ranges;
}

std::size_t Snapshot::bytes_beyond(const Snapshot& before) const {
  std::size_t own = 0;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    if (i >= before.chunks_.size() || chunks_[i] != before.chunks_[i]) ++own;
  }
  return own * sizeof(Chunk);
}

}  // namespace knead
