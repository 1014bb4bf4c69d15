// Positions of a shape's vertices at one moment, which share their memory with those of other moments as far as they
// are the same.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "knead/math/vec3.h"

namespace knead {

struct IndexRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  friend bool operator==(const IndexRange&, const IndexRange&) = default;
};

// Does not change; copies are cheap, and may be read from any thread.
class Snapshot {
 public:
  static constexpr std::size_t kChunk = 1024;  // vertices that are shared together

  Snapshot() = default;

  // Shares with `before`, where that has as many vertices, every chunk whose positions have the same bits. Time: a
  // comparison, and a copy of what differs. threads as parallel_for's.
  Snapshot(std::span<const Vec3d> positions, const Snapshot& before, int threads = 0);

  std::size_t size() const { return size_; }
  const Vec3d& operator[](std::size_t i) const { return (*chunks_[i / kChunk])[i % kChunk]; }

  void copy_to(std::span<Vec3d> positions) const;  // size() places
  std::vector<Vec3d> copy() const;

  // The vertices, by whole chunks, that may differ from those of a snapshot of the same size; neighbouring chunks
  // joined. All where the sizes differ.
  std::vector<IndexRange> changes_since(const Snapshot& before) const;

  // Bytes of the chunks that `before` does not share.
  std::size_t bytes_beyond(const Snapshot& before) const;

 private:
  using Chunk = std::array<Vec3d, kChunk>;  // what is beyond the last vertex is zero

  std::size_t size_ = 0;
  std::vector<std::shared_ptr<const Chunk>> chunks_;
};

}  // namespace knead
