// How far a session can be applied before it spoils a cell.
#include "knead/certify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "support/volume_mesh.h"

namespace knead::safe_until_test {
namespace {

TEST(SafeUntil, FindsTheFirstFailure) {
  for (const double bound : {0.0, 0.3, 1.7, 2.999}) {
    int calls = 0;
    const SafeUntil found = safe_until(3, [&](double until) {
      ++calls;
      return until <= bound;
    });
    EXPECT_LE(found.until, bound);
    EXPECT_GT(found.beyond, bound);
    EXPECT_LE(found.beyond - found.until, 1.0 / 16 / 1024 + 1e-15);
    EXPECT_LE(calls, 3 * 16 + 10);
    EXPECT_EQ(strokes_before(found), static_cast<std::size_t>(bound));
  }
}

TEST(SafeUntil, SeesWhatFailsAndRecovers) {
  const SafeUntil found = safe_until(1, [](double until) { return until < 0.3 || until > 0.38; });
  EXPECT_LT(found.until, 0.3);
  EXPECT_NEAR(found.until, 0.3, 1e-4);
}

TEST(SafeUntil, EndsAtTheEnd) {
  for (const double most : {0.0, 0.01, 1.0, 2.5, 100.0}) {
    int calls = 0;
    const SafeUntil found = safe_until(most, [&](double until) {
      EXPECT_LE(until, most);
      ++calls;
      return true;
    });
    EXPECT_EQ(found.until, most);
    EXPECT_EQ(found.beyond, most);
    EXPECT_LE(calls, 256);
  }
}

Session session_of(const std::string& lines) { return parse_session("{\"knead\": 1}\n" + lines, "cells"); }

std::string turn(double degrees) {
  return "{\"tool\": \"rotate\", \"center\": [0, 0, 0], \"axis\": [0, 0, 1], \"angle_deg\": " +
         std::to_string(degrees) + ", \"inner\": 0.4, \"outer\": 0.7}\n";
}

constexpr const char* kSlight =
    R"({"tool": "implicit", "path": [[0.3, 0, 0], [0.35, 0, 0]], "inner": 0.1, "outer": 0.5}
)";

// The least scaled Jacobian of the cells that were not below the bound before, and whether one is inverted.
struct Judgement {
  double least = 1;
  bool is_inverted = false;
  std::size_t worst = 0;
};

Judgement judged(const test::VolumeMesh& volume, const Session& session, const SessionPart& part, double bound) {
  std::vector<Vec3d> moved = volume.points;
  EXPECT_EQ(advect(flow_of(session, part), moved, advect_options({}, reference_length(moved))).status,
            AdvectStatus::done);
  const CellChanges before = compare_cells(volume.cells, volume.points, volume.points);
  const CellChanges after = compare_cells(volume.cells, volume.points, moved);
  Judgement found;
  found.is_inverted = after.inverted > 0;
  for (std::size_t i = 0; i < volume.cells.size(); ++i) {
    if (before.scaled_jacobian[i] < bound || !(after.scaled_jacobian[i] < found.least)) continue;
    found.least = after.scaled_jacobian[i];
    found.worst = i;
  }
  return found;
}

class SafeCellsOf : public testing::TestWithParam<CellKind> {};

TEST_P(SafeCellsOf, AStrokeThatIsTooStrong) {
  const test::VolumeMesh volume = test::box_of_cells(12, GetParam());
  const Session session = session_of(kSlight + turn(170));
  for (const double bound : {0.0, 0.1, 0.3}) {
    SafeCellsOptions options;
    options.least_scaled_jacobian = bound;
    const SafeCells found = safe_until(session, volume.cells, volume.points, options);
    EXPECT_EQ(found.status, AdvectStatus::done);
    EXPECT_GT(found.range.until, 1);
    EXPECT_LT(found.range.until, 2);
    EXPECT_LE(found.range.beyond - found.range.until, 1.0 / 16 / 1024 + 1e-15);
    const Judgement good = judged(volume, session, {Direction::forwards, found.range.until}, bound);
    EXPECT_FALSE(good.is_inverted);
    EXPECT_GE(good.least, bound);
    const Judgement bad = judged(volume, session, {Direction::forwards, found.range.beyond}, bound);
    EXPECT_TRUE(bound == 0 ? bad.is_inverted : bad.least < bound);
    ASSERT_TRUE(found.cell);
    EXPECT_EQ(*found.cell, bad.worst);
    EXPECT_EQ(found.scaled_jacobian, bad.least);
    ASSERT_TRUE(found.outer);
    EXPECT_NEAR(*found.outer, 1, 2e-3);  // from the centre to the faces

    options.motion.threads = 1;
    const SafeCells alone = safe_until(session, volume.cells, volume.points, options);
    EXPECT_EQ(alone.range.until, found.range.until);
    EXPECT_EQ(alone.cell, found.cell);
  }
}

// At its end this session inverts no cell, but on the way there.
TEST_P(SafeCellsOf, AMotionThatGoesBack) {
  const test::VolumeMesh volume = test::box_of_cells(12, GetParam());
  const Session session = session_of(turn(170) + turn(-170));
  EXPECT_FALSE(judged(volume, session, {}, 0).is_inverted);
  const SafeCells found = safe_until(session, volume.cells, volume.points);
  EXPECT_TRUE(found.cell);
  EXPECT_LT(found.range.until, 1);
}

TEST_P(SafeCellsOf, AnInverse) {
  const test::VolumeMesh volume = test::box_of_cells(12, GetParam());
  SafeCellsOptions options;
  options.part.direction = Direction::backwards;
  const Session session = session_of(turn(170));
  const SafeCells found = safe_until(session, volume.cells, volume.points, options);
  ASSERT_TRUE(found.cell);
  EXPECT_FALSE(judged(volume, session, {Direction::backwards, found.range.until}, 0).is_inverted);
  EXPECT_TRUE(judged(volume, session, {Direction::backwards, found.range.beyond}, 0).is_inverted);
}

TEST_P(SafeCellsOf, ASlightStrokeAreAll) {
  const test::VolumeMesh volume = test::box_of_cells(8, GetParam());
  const SafeCells found = safe_until(session_of(kSlight), volume.cells, volume.points);
  EXPECT_EQ(found.range.until, 1);
  EXPECT_FALSE(found.cell);
  EXPECT_FALSE(found.outer);
  EXPECT_EQ(safe_until(session_of(""), volume.cells, volume.points).range.until, 0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SafeCellsOf, testing::Values(CellKind::tetrahedron, CellKind::hexahedron),
                         testing::PrintToStringParamName());

// A cell that was bad before does not hold the motion back, unless it is inverted.
TEST(SafeCells, DoNotCountWhatWasBadBefore) {
  test::VolumeMesh volume = test::box_of_cells(8, CellKind::tetrahedron);
  Vec3d& thin = volume.points[volume.points.size() / 2];  // in the middle
  ASSERT_EQ(norm(thin), 0);
  thin = {0.24, 0, 0};
  SafeCellsOptions options;
  options.least_scaled_jacobian = 0.1;
  const CellChanges before = compare_cells(volume.cells, volume.points, volume.points);
  ASSERT_LT(*std::min_element(before.scaled_jacobian.begin(), before.scaled_jacobian.end()), 0.1);
  EXPECT_FALSE(safe_until(session_of(kSlight), volume.cells, volume.points, options).cell);
  const SafeCells strong = safe_until(session_of(turn(170)), volume.cells, volume.points, options);
  ASSERT_TRUE(strong.cell);
  EXPECT_GT(strong.range.until, 0.1);
}

TEST(SafeCells, RefuseWhatIsOutOfRange) {
  const test::VolumeMesh volume = test::box_of_cells(2, CellKind::tetrahedron);
  SafeCellsOptions options;
  for (const double bad : {-0.1, 1.0, std::nan("")}) {
    options.least_scaled_jacobian = bad;
    EXPECT_THROW(safe_until(session_of(kSlight), volume.cells, volume.points, options), InvalidInput);
  }
  options = {};
  options.part.until = 2;
  EXPECT_THROW(safe_until(session_of(kSlight), volume.cells, volume.points, options), InvalidInput);
  EXPECT_THROW(safe_until(session_of(kSlight), volume.cells, std::span(volume.points).first(5)), InvalidInput);
  EXPECT_EQ(safe_until(session_of(kSlight), {}, {}).range.until, 1);
}

TEST(SafeCells, CanBeCancelled) {
  const test::VolumeMesh volume = test::box_of_cells(8, CellKind::tetrahedron);
  Progress progress;
  progress.cancel = true;
  SafeCellsOptions options;
  options.progress = &progress;
  EXPECT_THROW(safe_until(session_of(turn(170)), volume.cells, volume.points, options), Cancelled);
}

}  // namespace
}  // namespace knead::safe_until_test
