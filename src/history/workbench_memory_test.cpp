// What an editor keeps for undo, what it makes again, and what it leaves for later.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <string>
#include <thread>

#include "knead/editor/workbench.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::workbench_memory_test {
namespace {

constexpr std::size_t kStrokes = 300;

// Small strokes all over a ball of radius 1.
SessionStroke stroke_number(std::size_t i) {
  const double a = 0.7 * static_cast<double>(i);
  const double b = 0.31 * static_cast<double>(i);
  const Vec3d p{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
  if (i % 10 == 3) return {RelaxStroke{{p}, 0.4}};
  return {ImplicitStroke{{p, p * 1.01 + Vec3d{0.004, 0, 0.003}}, 0.2, 0.7}};
}

std::vector<Vec3d> positions(const Workbench& bench) { return bench.state().positions.copy(); }

TEST(WorkbenchMemory, ThreeHundredStrokesAreUndoneToTheBitWithinASmallBudget) {
  const Mesh ball = make_shape(ShapeKind::sphere, 2562);
  Workbench bench(ball);
  const std::size_t state = 2562 * sizeof(Vec3d);
  const std::size_t budget = 12 * state;
  bench.limit_memory(budget);
  DeformedShape shape(borrow(ball));
  std::vector<std::vector<Vec3d>> expected{ball.positions};
  for (std::size_t i = 0; i < kStrokes; ++i) {
    ASSERT_TRUE(bench.append({stroke_number(i)}).is_done());
    ASSERT_LE(bench.undo_memory().bytes, budget);
    shape.apply(stroke_number(i));
    expected.push_back(shape.positions());
  }
  ASSERT_EQ(bench.done().size(), kStrokes);
  EXPECT_LT(bench.undo_memory().states, 30U);
  for (std::size_t i = kStrokes; i-- > 0;) {
    ASSERT_TRUE(bench.undo().is_done());
    ASSERT_TRUE(positions(bench) == expected[i]) << i;
    ASSERT_LE(bench.undo_memory().bytes, budget);
  }
  EXPECT_FALSE(bench.can_undo());
  for (std::size_t i = 1; i <= kStrokes; ++i) {
    ASSERT_TRUE(bench.redo().is_done());
    ASSERT_TRUE(positions(bench) == expected[i]) << i;
  }
  EXPECT_FALSE(bench.can_redo());
}

// How many vertices moved, times segments, since the last call: 0 if a state was there at once.
struct Work {
  Progress progress;

  std::uint64_t take() { return progress.done.exchange(0); }
};

TEST(WorkbenchMemory, KeepsTheLastHundredStatesWhereTheyFit) {
  Workbench bench(make_shape(ShapeKind::sphere, 642));
  bench.limit_memory(130 * (642 * sizeof(Vec3d) + 10'000));
  for (std::size_t i = 0; i < kStrokes; ++i) ASSERT_TRUE(bench.append({stroke_number(i)}).is_done());
  Work work;
  for (int i = 0; i < 99; ++i) {
    ASSERT_TRUE(bench.undo(&work.progress).is_done());
    ASSERT_EQ(work.take(), 0U) << i;
  }
}

TEST(WorkbenchMemory, ThePresentStateStaysWhateverTheBudget) {
  const Mesh ball = make_shape(ShapeKind::sphere, 642);
  Workbench bench(ball);
  bench.limit_memory(0);
  for (std::size_t i = 0; i < 5; ++i) ASSERT_TRUE(bench.append({stroke_number(i)}).is_done());
  EXPECT_EQ(bench.undo_memory().states, 1U);
  const std::vector<Vec3d> last = positions(bench);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(bench.undo().is_done());
  EXPECT_TRUE(positions(bench) == ball.positions);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(bench.redo().is_done());
  EXPECT_TRUE(positions(bench) == last);
}

TEST(WorkbenchMemory, ACancelledReplayForUndoLeavesTheShape) {
  Workbench bench(make_shape(ShapeKind::sphere, 642));
  bench.limit_memory(0);
  for (std::size_t i = 0; i < 5; ++i) ASSERT_TRUE(bench.append({stroke_number(i)}).is_done());
  const std::vector<Vec3d> last = positions(bench);
  Progress progress;
  progress.cancel = true;
  EXPECT_EQ(bench.undo(&progress).status, AdvectStatus::cancelled);
  EXPECT_TRUE(positions(bench) == last);
  EXPECT_EQ(bench.done().size(), 5U);
  progress.cancel = false;
  EXPECT_TRUE(bench.undo(&progress).is_done());
  EXPECT_EQ(bench.done().size(), 4U);
}

SessionStroke remeshed(const Vec3d& from, const Vec3d& to) {
  SessionStroke stroke{ImplicitStroke{{from, to}, 0.2, 0.6}};
  stroke.remesh = RemeshSettings{};
  return stroke;
}

struct Lines {
  std::vector<SessionStroke> strokes;

  void follow(const LineChange& change) {
    ASSERT_LE(change.undone, strokes.size());
    strokes.resize(strokes.size() - change.undone);
    strokes.insert(strokes.end(), change.appended.begin(), change.appended.end());
  }
};

void expect_as_replayed(const Workbench& bench, const Mesh& mesh, const std::vector<SessionStroke>& strokes) {
  Session session;
  session.name = "later.knead";
  session.strokes = strokes;
  const ReplayResult expected = replay(mesh, session);
  EXPECT_TRUE(positions(bench) == expected.shape.positions());
  EXPECT_EQ(bench.state().to_mesh().corner_vertex, expected.shape.mesh().corner_vertex);
}

class Deferred : public testing::Test {
 protected:
  const Mesh ball_ = make_shape(ShapeKind::sphere, 642);
  const SessionStroke first_ = remeshed({0, 1, 0}, {0, 1.15, 0});
  const SessionStroke second_ = remeshed({0, 1.1, 0}, {0.1, 1.2, 0});
  Workbench bench_{ball_};
  Lines lines_;

  void draw(const SessionStroke& stroke) {
    lines_.follow(bench_.set_live({stroke}).lines);
    lines_.follow(bench_.finish_later().lines);
  }
};

TEST_F(Deferred, RemeshingGivesTheBitsOfAReplayOfTheSession) {
  draw(first_);
  EXPECT_FALSE(bench_.is_settled());
  EXPECT_EQ(bench_.state().mesh, bench_.base().mesh);
  draw(second_);
  draw({ImplicitStroke{{{1, 0, 0}, {1.1, 0, 0}}, 0.2, 0.6}});
  EXPECT_EQ(lines_.strokes.size(), 3U);
  EXPECT_EQ(bench_.done().size(), 3U);
  lines_.follow(bench_.settle().lines);
  EXPECT_TRUE(bench_.is_settled());
  ASSERT_EQ(lines_.strokes, bench_.strokes());
  expect_as_replayed(bench_, ball_, lines_.strokes);
  for (int i = 2; i >= 0; --i) {
    lines_.follow(bench_.undo().lines);
    expect_as_replayed(bench_, ball_, lines_.strokes);
  }
}

TEST_F(Deferred, ACancelledSettleGoesOnLater) {
  draw(first_);
  draw(second_);
  const std::vector<Vec3d> about = positions(bench_);
  Progress progress;
  progress.cancel = true;
  EXPECT_EQ(bench_.settle(&progress).status, AdvectStatus::cancelled);
  EXPECT_FALSE(bench_.is_settled());
  EXPECT_TRUE(positions(bench_) == about);
  draw({ImplicitStroke{{{1, 0, 0}, {1.1, 0, 0}}, 0.2, 0.6}});
  lines_.follow(bench_.settle().lines);
  expect_as_replayed(bench_, ball_, lines_.strokes);
}

TEST_F(Deferred, UndoAndEditAndAppendGiveTheBitsOfAReplay) {
  draw(first_);
  draw(second_);
  lines_.follow(bench_.undo().lines);
  EXPECT_EQ(lines_.strokes.size(), 1U);
  lines_.follow(bench_.redo().lines);
  lines_.follow(bench_.edit(0, {remeshed({0, 1, 0}, {0, 1.1, 0})}).lines);
  expect_as_replayed(bench_, ball_, lines_.strokes);
  draw(first_);
  lines_.follow(bench_.append({second_}).lines);
  expect_as_replayed(bench_, ball_, lines_.strokes);
  draw(first_);
  lines_.follow(bench_.set_live({second_}).lines);
  lines_.follow(bench_.finish().lines);
  EXPECT_TRUE(bench_.is_settled());
  expect_as_replayed(bench_, ball_, lines_.strokes);
}

// Handles by numbers of vertices fit the shape that is shown, but not the remeshed one.
TEST_F(Deferred, AStrokeThatTheTrueShapeRefusesGoes) {
  draw(first_);
  HandlesStroke handles;
  handles.full_vertices = {0, 1};
  handles.zero_vertices = {2, 3};
  handles.motion = HandlesTranslation{{0, 0.01, 0}};
  draw({handles});
  draw(second_);
  ASSERT_EQ(lines_.strokes.size(), 3U);
  const WorkResult result = bench_.settle();
  EXPECT_NE(result.refusal.find("names vertices"), std::string::npos) << result.refusal;
  lines_.follow(result.lines);
  EXPECT_TRUE(bench_.is_settled());
  ASSERT_EQ(lines_.strokes.size(), 2U);
  EXPECT_EQ(lines_.strokes, bench_.strokes());
  expect_as_replayed(bench_, ball_, lines_.strokes);
  lines_.follow(bench_.undo().lines);
  expect_as_replayed(bench_, ball_, lines_.strokes);
  lines_.follow(bench_.undo().lines);
  EXPECT_TRUE(positions(bench_) == ball_.positions);
  EXPECT_FALSE(bench_.can_undo());
}

// The work is cancelled at each of its steps in turn.
TEST_F(Deferred, RemeshingLooksForCancelAllTheTime) {
  draw(first_);
  std::size_t cancelled = 0;
  for (std::uint64_t steps = 0; steps < 9; ++steps) {
    Workbench copy = bench_;
    Progress progress;
    std::atomic<bool> is_done{false};
    std::thread canceller([&] {
      while (!is_done && (progress.total == 0 || progress.done < steps)) std::this_thread::yield();
      progress.cancel = true;
    });
    const WorkResult result = copy.settle(&progress);
    is_done = true;
    canceller.join();
    if (result.is_done()) continue;
    ++cancelled;
    EXPECT_EQ(result.status, AdvectStatus::cancelled);
    EXPECT_TRUE(positions(copy) == positions(bench_));
  }
  EXPECT_GT(cancelled, 0U);
}

}  // namespace
}  // namespace knead::workbench_memory_test
