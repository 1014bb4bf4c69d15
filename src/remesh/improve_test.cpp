// Rounds of improvement: better triangles, the same volume, the same bits.
#include "remesh/improve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "knead/mesh.h"
#include "remesh/improver.h"
#include "remesh/surface.h"

namespace knead::detail::improve_test {
namespace {

// A sphere whose vertices are moved randomly along it: bad triangles everywhere.
Surface stirred_ball(std::size_t vertices = 2500) {
  const Mesh ball = make_shape(ShapeKind::sphere, vertices);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> by(-0.03, 0.03);
  Surface s;
  for (const Vec3d& p : ball.positions) {
    const double x = by(random);
    const double y = by(random);
    const double z = by(random);
    s.after.push_back(normalized(p + Vec3d{x, y, z}));
  }
  s.before = s.after;
  for (std::size_t f = 0; f < ball.face_count(); ++f) {
    for (const std::uint32_t v : ball.face(f)) s.corner.push_back(v);
    s.face_source.push_back(0);
  }
  connect(s);
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    s.set(v, kMoved);
    s.set(v, kRegion);
  }
  return s;
}

Improvement improvement() {
  Improvement result;
  result.targets.max_edge = 1;
  result.targets.min_edge = 0.01;
  result.targets.max_chord = 3e-3;
  result.targets.iterations = 4;
  return result;
}

double worst(const Surface& s) {
  double least = 1;
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    if (s.is_alive(f)) least = std::min(least, quality(s, f, s.after));
  }
  return std::atan(least) * 180 / std::numbers::pi;
}

TEST(Improve, TrianglesGetBetterAndTheVolumeStays) {
  Surface s = stirred_ball();
  const double volume = enclosed_volume(s, s.after);
  EXPECT_LT(worst(s), 5);
  double lost = improve(s, improvement()).volume;
  for (int level = 0; level < kRepairLevels; ++level) lost += repair_triangles(s, improvement(), level).volume;
  spread_volume(s, lost, kInfinity, {});
  EXPECT_GT(worst(s), 10);
  EXPECT_NEAR(enclosed_volume(s, s.after), volume, 1e-11);
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    if (s.has(v, kRemoved)) continue;
    EXPECT_NEAR(norm(s.after[v]), 1, 2 * improvement().targets.max_chord);
  }
}

// So many vertices are several blocks, which several threads change at the same time.
TEST(Improve, HasTheSameBitsForEveryNumberOfThreads) {
  const Surface stirred = stirred_ball(40'000);
  Improvement task = improvement();
  Surface one = stirred;
  improve(one, task);
  for (const int threads : {2, 3}) {
    task.threads = threads;
    Surface many = stirred;
    improve(many, task);
    EXPECT_EQ(many.after, one.after);
    EXPECT_EQ(many.corner, one.corner);
  }
  EXPECT_NE(one.after, stirred.after);
}

// What rests is not tried again, and qualities are kept: neither changes what is done.
TEST(Improve, AMemoryOfTheSurfaceChangesNoBit) {
  Surface with = stirred_ball();
  Surface without = with;
  Improvement task = improvement();
  improve(without, task);
  repair_triangles(without, task, 0);
  SurfaceMemory memory;
  task.memory = &memory;
  improve(with, task);
  repair_triangles(with, task, 0);
  EXPECT_EQ(with.after, without.after);
  for (std::size_t f = 0; f < with.face_count(); ++f) {
    if (!with.is_alive(f)) continue;
    EXPECT_EQ(memory.quality(with, f), quality(with, f, with.after));
  }
}

TEST(Improve, FixedVerticesStay) {
  Surface s = stirred_ball();
  for (std::uint32_t v = 0; v < s.vertex_count(); v += 2) s.set(v, kImmovable);
  const Surface was = s;
  improve(s, improvement());
  repair_crossings(s, improvement(), std::vector<std::uint32_t>{0, 1, 2, 3, 4});
  for (std::size_t v = 0; v < s.vertex_count(); v += 2) EXPECT_EQ(s.after[v], was.after[v]);
}

TEST(Improve, WithoutRoundsNothingHappens) {
  Surface s = stirred_ball();
  const Surface was = s;
  Improvement task = improvement();
  task.targets.iterations = 0;
  improve(s, task);
  EXPECT_EQ(s.after, was.after);
  EXPECT_EQ(s.corner, was.corner);
}

// Where creases keep every vertex and edge, thin triangles can only be split, which makes more of them.
TEST(Improve, DoesNotSplitWithoutEndWhereNothingElseHelps) {
  Surface s = stirred_ball();
  std::fill(s.edge_flags.begin(), s.edge_flags.end(), static_cast<std::uint8_t>(kFeature | kCrease));
  for (Vec3d& p : s.after) p.z *= 0.002;
  const std::size_t faces = s.face_count();
  Improvement wanted = improvement();
  wanted.targets.max_chord = 1e-6;
  repair_triangles(s, wanted, 3);
  EXPECT_LE(s.face_count(), 2 * faces);
}

TEST(Compensation, GivesBackWhatItIsAskedFor) {
  Surface s = stirred_ball();
  std::vector<Vec3d> deviations(s.halfedge.size());
  for (std::size_t e = 0; e < deviations.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    const Vec3d chord = (s.after[s.origin(h)] + s.after[s.target(h)]) * 0.5;
    deviations[e] = normalized(chord) - chord;
  }
  const double was = enclosed_volume(s, s.after);
  const double missing = 4 * std::numbers::pi / 3 - was;
  EXPECT_NEAR(estimate_missing_volume(s, deviations).sum / missing, 1, 0.05);
  EXPECT_NEAR(compensate(s, deviations, {}, missing), missing, 1e-9);
  EXPECT_NEAR(enclosed_volume(s, s.after), 4 * std::numbers::pi / 3, 1e-9);
}

}  // namespace
}  // namespace knead::detail::improve_test
