// The guard refuses exactly the changes that make more triangles cross.
#include "remesh/crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "knead/mesh.h"
#include "remesh/improve.h"
#include "remesh/improver.h"

namespace knead::detail::crossing_guard_test {
namespace {

// Two balls inside each other, close together. The patch holds the faces above the equator.
struct Balls {
  Mesh mesh;
  Patch patch;

  explicit Balls(double gap) {
    const Mesh ball = make_shape(ShapeKind::sphere, 400);
    for (const double size : {1.0, 1 - gap}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertex_count());
      for (const Vec3d& p : ball.positions) mesh.positions.push_back(p * size);
      for (std::size_t f = 0; f < ball.face_count(); ++f) {
        for (const std::uint32_t v : ball.face(f)) mesh.corner_vertex.push_back(first + v);
        mesh.face_begin.push_back(static_cast<std::uint32_t>(mesh.corner_vertex.size()));
      }
    }
    std::vector<Vec3d> after = mesh.positions;
    for (Vec3d& p : after) {
      if (p.z > 0) p.x *= 1 + 1e-9;
    }
    Deformation deformation;
    deformation.carry = [](std::span<Vec3d>) {};
    patch = extract_patch(mesh, after, deformation, RemeshOptions{});
  }
};

std::size_t count_crossings(const CrossingSearch& search, const Surface& s) {
  const CrossingSearch::Triangles all = search.triangles(s);
  return self_intersections(all.triangles, all.positions).count;
}

std::vector<std::uint32_t> crossing_faces(CrossingGuard& guard, const Surface& s) {
  std::vector<std::uint32_t> faces;
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    if (guard.crosses(f)) faces.push_back(f);
  }
  return faces;
}

// Balls with a guard of the patch.
struct Guarded {
  Balls balls;
  Surface& s = balls.patch.surface;
  CrossingSearch search{balls.mesh, balls.patch, true, 1};
  CrossingGuard guard{s, search};

  explicit Guarded(double gap = 0.02) : balls(gap) {}
};

TEST(CrossingGuard, IsSpentAfterManyTestsAndEndsTheWork) {
  Guarded guarded(1e-12);  // the balls overlap everywhere
  Surface& s = guarded.s;
  CrossingGuard& guard = guarded.guard;
  guard.watch_everything();
  const auto ask_everywhere = [&] {
    for (std::uint32_t v = 0; v < s.vertex_count(); ++v) guard.allows_move({&v, 1}, {1e-13, 1e-13, 0});
  };
  ask_everywhere();
  EXPECT_FALSE(guard.is_spent());
  for (int i = 0; i < 10'000 && !guard.is_spent(); ++i) ask_everywhere();
  EXPECT_TRUE(guard.is_spent());
  RemeshTargets targets;
  targets.max_chord = 1e-3;
  const std::vector<Vec3d> places = s.after;
  EXPECT_EQ(improve(s, {targets, nullptr, &guard}).flips, 0U);
  EXPECT_EQ(s.after, places);
}

TEST(CrossingGuard, AllowsAMoveExactlyIfNothingCrossesThenOrLessThanBefore) {
  Guarded guarded;
  auto& [balls, s, search, guard] = guarded;
  guard.watch_everything();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> by(-0.05, 0.05);
  int allowed = 0;
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    const auto v = static_cast<std::uint32_t>(random() % s.vertex_count());
    if (s.has(v, kImmovable)) continue;
    const double x = by(random);
    const double y = by(random);
    const Vec3d d{x, y, by(random)};
    const std::size_t was = count_crossings(search, s);
    const bool allows = guard.allows_move({&v, 1}, d);
    s.after[v] += d;
    const std::size_t is = count_crossings(search, s);
    if (is != was || is == 0) {
      EXPECT_EQ(allows, is < was || is == 0) << i;
    }
    ++(allows ? allowed : refused);
    // Now and then a move that crosses is kept, so that there is something to undo.
    if (allows || i % 50 == 0) {
      guard.update_around(v);
    } else {
      s.after[v] -= d;
    }
  }
  EXPECT_GT(allowed, 50);
  EXPECT_GT(refused, 50);
}

TEST(CrossingGuard, ImprovingUnderItMakesNothingCross) {
  Guarded guarded(0.01);
  auto& [balls, s, search, guard] = guarded;
  guard.watch_everything();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> by(-0.12, 0.12);
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {  // poor triangles, but none that cross
    const double x = by(random);
    const double y = by(random);
    const Vec3d& p = s.after[v];
    const Vec3d d = normalized(p + Vec3d{x, y, by(random)}) * norm(p) - p;  // along the ball
    if (s.has(v, kImmovable) || !guard.allows_move({&v, 1}, d)) continue;
    s.after[v] += d;
    guard.update_around(v);
  }
  ASSERT_EQ(count_crossings(search, s), 0U);
  Improvement task;
  task.targets.max_edge = 1;
  task.targets.min_edge = 0.05;
  task.targets.max_chord = 0.02;
  task.targets.iterations = 4;
  const Surface poor = s;
  const auto run = [&task](Surface& surface) {
    ImprovementCounts counts = improve(surface, task);
    for (int level = 0; level < kGuardedLevels; ++level) counts += repair_triangles(surface, task, level);
    return counts;
  };
  run(s);
  EXPECT_GT(count_crossings(search, s), 0U);  // without a guard
  s = poor;
  CrossingGuard fresh(s, search);
  fresh.watch_everything();
  task.guard = &fresh;
  const ImprovementCounts counts = run(s);
  EXPECT_GT(counts.flips, 20U);
  EXPECT_GT(counts.collapses, 3U);
  EXPECT_EQ(count_crossings(search, s), 0U);
  EXPECT_TRUE(crossing_faces(fresh, s).empty());
}

TEST(CrossingGuard, KnowsTheFacesThatSplitsHaveMade) {
  Guarded guarded;
  auto& [balls, s, search, guard] = guarded;
  guard.watch_everything();
  Improvement task;
  task.targets.max_chord = 1e-3;
  task.guard = &guard;
  Improver improver(s, task);
  for (std::uint32_t h = 0; h < 600; h += 3) improver.split_chord(h);
  ASSERT_GT(improver.counts().splits, 50U);
  const auto last = static_cast<std::uint32_t>(s.vertex_count() - 1);
  const double inwards = norm(s.after[last]) > 0.985 ? -0.1 : 0.1;  // towards the other ball
  EXPECT_FALSE(guard.allows_move({&last, 1}, s.after[last] * inwards));
  EXPECT_TRUE(guard.allows_move({&last, 1}, s.after[last] * (inwards / 100)));
  s.after[last] = s.after[last] * (1 + inwards);
  guard.update_around(last);
  EXPECT_EQ(crossing_faces(guard, s), search.find(balls.patch).faces);
}

TEST(CrossingGuard, WatchesTheGivenPlacesOnly) {
  Guarded guarded;
  auto& [balls, s, search, guard] = guarded;
  const auto top = static_cast<std::uint32_t>(
      std::max_element(s.after.begin(), s.after.end(), [](const Vec3d& a, const Vec3d& b) { return a.z < b.z; }) -
      s.after.begin());
  EXPECT_TRUE(guard.allows_move({&top, 1}, {0, 0, -0.5}));
  Box elsewhere;
  elsewhere.extend({0.9, -0.1, 0.1});
  elsewhere.extend({1.1, 0.1, 0.3});
  guard.watch({&elsewhere, 1});
  EXPECT_TRUE(guard.allows_move({&top, 1}, {0, 0, -0.5}));
  Box here;
  here.extend(s.after[top]);
  guard.watch({&here, 1});
  EXPECT_FALSE(guard.allows_move({&top, 1}, {0, 0, -0.5}));
}

// Moves a vertex of the inner ball out through the outer one; returns it.
std::uint32_t pushed_out(Surface& s) {
  std::uint32_t inner = 0;
  while (s.after[inner].z < 0.8 || norm(s.after[inner]) > 0.99) ++inner;
  s.after[inner] = s.after[inner] * 1.1;
  return inner;
}

TEST(CrossingGuard, NamesTheFacesThatCross) {
  Guarded guarded;
  auto& [balls, s, search, guard] = guarded;
  const std::uint32_t inner = pushed_out(s);
  guard.update_around(inner);
  const std::vector<std::uint32_t> found = crossing_faces(guard, s);
  EXPECT_EQ(found, search.find(balls.patch).faces);
  EXPECT_FALSE(found.empty());
}

TEST(CrossingSearch, OfSomeFacesFindsThePairsWithOneOfThem) {
  Guarded guarded;
  auto& [balls, s, search, guard] = guarded;
  const std::uint32_t inner = pushed_out(s);
  const Crossings all = search.find(balls.patch);
  ASSERT_GT(all.pairs, 0U);
  std::vector<bool> only(s.face_count(), false);
  for (const std::uint32_t f : all.faces) {
    const Triangle t = s.triangle(f);
    only[f] = std::find(t.begin(), t.end(), inner) != t.end();
  }
  EXPECT_EQ(search.find(balls.patch, only).pairs, all.pairs);  // each pair has a face that moved
  for (std::uint32_t f = 0; f < s.face_count(); ++f) {
    only[f] = !std::binary_search(all.faces.begin(), all.faces.end(), f);
  }
  EXPECT_EQ(search.find(balls.patch, only).pairs, 0U);
}

}  // namespace
}  // namespace knead::detail::crossing_guard_test
