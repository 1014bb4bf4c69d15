// Positions that share memory with earlier ones.
#include <gtest/gtest.h>

#include <set>

#include "knead/editor/shape_state.h"

namespace knead::snapshot_test {
namespace {

std::vector<Vec3d> numbered(std::size_t count) {
  std::vector<Vec3d> positions(count);
  for (std::size_t i = 0; i < count; ++i) positions[i] = {static_cast<double>(i), 0.5, -0.0};
  return positions;
}

constexpr std::size_t kCount = 5 * Snapshot::kChunk + 17;

TEST(Snapshot, HoldsWhatItWasGivenToTheBit) {
  const std::vector<Vec3d> positions = numbered(kCount);
  const Snapshot snapshot(positions, Snapshot());
  ASSERT_EQ(snapshot.size(), kCount);
  EXPECT_EQ(snapshot.copy(), positions);
  EXPECT_EQ(snapshot[kCount - 1], positions.back());
  EXPECT_TRUE(std::signbit(snapshot.copy()[3].z));
}

TEST(Snapshot, TellsByChunksWhatDiffersAndSharesTheRest) {
  std::vector<Vec3d> positions = numbered(kCount);
  const Snapshot before(positions, Snapshot());
  positions[Snapshot::kChunk + 5].y = 7;
  positions[2 * Snapshot::kChunk].z = 0.0;  // was -0
  positions[kCount - 1].x = 1;
  const Snapshot after(positions, before);
  const auto at = [](std::size_t i) { return static_cast<std::uint32_t>(i); };
  const std::vector<IndexRange> expected{{at(Snapshot::kChunk), at(3 * Snapshot::kChunk)},
                                         {at(5 * Snapshot::kChunk), at(kCount)}};
  EXPECT_EQ(after.changes_since(before), expected);
  EXPECT_EQ(before.changes_since(after), expected);
  std::set<const void*> chunks;
  const auto insert = [&](const void* address, std::size_t) { chunks.insert(address); };
  before.for_each_chunk(insert);
  const std::size_t count = chunks.size();
  after.for_each_chunk(insert);
  EXPECT_EQ(chunks.size(), count + 3);
  EXPECT_TRUE(Snapshot(positions, after).changes_since(after).empty());
}

TEST(Snapshot, OfAnotherSizeHasNothingInCommon) {
  const Snapshot small(numbered(10), Snapshot());
  const Snapshot large(numbered(Snapshot::kChunk + 1), small);
  EXPECT_EQ(large.changes_since(small), (std::vector<IndexRange>{{0, Snapshot::kChunk + 1}}));
  EXPECT_TRUE(Snapshot().changes_since(Snapshot()).empty());
}

TEST(Snapshot, IsTheSameForEveryNumberOfThreads) {
  const std::vector<Vec3d> positions = numbered(100 * Snapshot::kChunk);
  const Snapshot one(positions, Snapshot(), 1);
  EXPECT_TRUE(Snapshot(positions, one, 2).changes_since(one).empty());
}

}  // namespace
}  // namespace knead::snapshot_test
