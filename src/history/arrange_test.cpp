// The history as a list of entries that are rearranged.
#include <gtest/gtest.h>

#include "knead/editor/workbench.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::arrange_test {
namespace {

using Entries = std::vector<std::vector<SessionStroke>>;

Mesh ball() { return make_shape(ShapeKind::sphere, 2562); }

SessionStroke pull(double y) { return {ImplicitStroke{{{0, y, 1}, {0.1, y, 1.2}, {0.3, y, 1.3}}, 0.15, 0.5}}; }
SessionStroke turn(double angle) { return {RotateStroke{{0, 0, 1}, {0, 0, 1}, angle, 0.1, 0.6}}; }

// Three entries that act on each other.
Entries three() { return {{pull(0)}, {turn(30)}, {pull(0.3)}}; }

Workbench bench_of(const Entries& entries) {
  Workbench bench(ball());
  for (const std::vector<SessionStroke>& strokes : entries) EXPECT_TRUE(bench.append(strokes).is_done());
  EXPECT_EQ(bench.done().size(), entries.size());
  return bench;
}

std::vector<Vec3d> positions(const Workbench& bench) { return bench.state().positions.copy(); }

std::vector<Vec3d> replayed(const std::vector<SessionStroke>& strokes) {
  Session session;
  session.name = "s.knead";
  session.strokes = strokes;
  return replay(ball(), session).shape.positions();
}

// The lines of a session file that follows the changes.
struct Lines {
  std::vector<SessionStroke> strokes;

  void follow(const LineChange& change) {
    ASSERT_LE(change.undone, strokes.size());
    strokes.resize(strokes.size() - change.undone);
    strokes.insert(strokes.end(), change.appended.begin(), change.appended.end());
  }
};

// The state after an entry is known: to look at it costs no work.
std::uint64_t steps_of(const Workbench& bench, std::size_t entry) { return bench.done()[entry]->steps; }

TEST(Arrange, EveryArrangementHasTheBitsOfAReplayAndUndoTakesItBack) {
  const Entries start = three();
  Workbench bench = bench_of(start);
  const std::vector<Vec3d> before = positions(bench);
  Lines lines{bench.strokes()};
  Entries off = start;
  off[1][0].off = true;
  Entries weak = start;
  weak[0][0].strength = 0.5;
  Entries strong = start;
  strong[2][0].strength = 1.5;
  const std::vector<Entries> arrangements{
      off, weak, strong, {start[2], start[0], start[1]}, {start[0], {start[1][0], start[2][0]}}, {start[0], start[2]},
      {}};
  for (const Entries& entries : arrangements) {
    const WorkResult result = bench.arrange(entries, false);
    ASSERT_TRUE(result.is_done()) << result.refusal;
    lines.follow(result.lines);
    EXPECT_EQ(bench.done().size(), entries.size());
    EXPECT_EQ(lines.strokes, bench.strokes());
    EXPECT_TRUE(positions(bench) == replayed(bench.strokes()));
    lines.follow(bench.undo().lines);
    EXPECT_EQ(lines.strokes, bench.strokes());
    EXPECT_TRUE(positions(bench) == before);
    EXPECT_EQ(bench.done().size(), 3u);
  }
}

// Names, joining and splitting move nothing, so nothing is computed again.
TEST(Arrange, WhatMovesNothingComputesNothing) {
  Workbench bench = bench_of(three());
  const std::vector<Vec3d> before = positions(bench);
  Entries named = three();
  named[0][0].name = "nose";
  Entries joined{{named[0][0], named[1][0]}, named[2]};
  Entries with_off = joined;
  with_off.insert(with_off.begin() + 1, {pull(-0.5)});
  with_off[1][0].off = true;
  for (const Entries& entries : {named, joined, with_off, joined}) {
    Progress cancelled;
    cancelled.cancel = true;
    ASSERT_TRUE(bench.arrange(entries, false, &cancelled).is_done()) << "it applied a stroke";
    EXPECT_TRUE(positions(bench) == before);
    EXPECT_EQ(bench.done().size(), entries.size());
  }
  EXPECT_EQ(bench.done()[0]->strokes[0].name, "nose");
  EXPECT_EQ(bench.strokes().size(), 3u);
}

TEST(Arrange, ComputesOnlyWhatFollowsTheChange) {
  Workbench bench = bench_of(three());
  const std::shared_ptr<const HistoryEntry> first = bench.done()[0];
  Entries entries = three();
  entries[2][0].strength = 0.5;
  ASSERT_TRUE(bench.arrange(entries, false).is_done());
  EXPECT_EQ(bench.done()[0], first);
  EXPECT_GT(steps_of(bench, 2), 0u);
}

TEST(Arrange, ACancelledOneLeavesEverything) {
  Workbench bench = bench_of(three());
  const std::vector<Vec3d> before = positions(bench);
  const std::vector<SessionStroke> strokes = bench.strokes();
  Entries entries = three();
  entries[0][0].strength = 0.5;
  Progress cancelled;
  cancelled.cancel = true;
  const WorkResult result = bench.arrange(entries, false, &cancelled);
  EXPECT_EQ(result.status, AdvectStatus::cancelled);
  EXPECT_TRUE(result.lines.empty());
  EXPECT_TRUE(positions(bench) == before);
  EXPECT_EQ(bench.strokes(), strokes);
  ASSERT_TRUE(bench.undo().is_done());
  EXPECT_EQ(bench.done().size(), 2u) << "undo takes back the last entry, not the cancelled change";
}

TEST(Arrange, StepsOfOneDragAreOneChange) {
  Workbench bench = bench_of(three());
  const std::vector<Vec3d> before = positions(bench);
  Lines lines{bench.strokes()};
  LineChange all;
  Entries entries = three();
  for (int i = 0; i < 5; ++i) {
    entries[1][0].strength = 0.2 * i;
    const WorkResult result = bench.arrange(entries, i > 0);
    ASSERT_TRUE(result.is_done());
    all = joined_changes(std::move(all), result.lines);
  }
  lines.follow(all);
  EXPECT_EQ(lines.strokes, bench.strokes());
  EXPECT_LE(all.appended.size(), 2u) << "only the last step is in the lines";
  EXPECT_TRUE(positions(bench) == replayed(bench.strokes()));
  bench.undo();
  EXPECT_TRUE(positions(bench) == before);
  ASSERT_TRUE(bench.redo().is_done());
  EXPECT_EQ(bench.done()[1]->strokes[0].strength, 0.8);
}

TEST(Arrange, AStateThatCannotBeReachedIsRefused) {
  Workbench bench = bench_of(three());
  Entries entries = three();
  HandlesStroke handles;
  handles.full_vertices = {1'000'000};
  handles.zero_vertices = {0};
  handles.motion = HandlesTranslation{{0, 0.1, 0}};
  entries.push_back({{handles}});
  const std::vector<Vec3d> before = positions(bench);
  const WorkResult result = bench.arrange(entries, false);
  EXPECT_FALSE(result.refusal.empty());
  EXPECT_TRUE(positions(bench) == before);
  EXPECT_EQ(bench.done().size(), 3u);
}

}  // namespace
}  // namespace knead::arrange_test
