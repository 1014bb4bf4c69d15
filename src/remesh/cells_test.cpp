// deform_cells(): interior points move until cells are good, and fixed ones do not.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "knead/error.h"
#include "knead/remesh.h"
#include "support/volume_mesh.h"

namespace knead::cells_test {
namespace {

using test::box_of_cells;
using Volume = test::VolumeMesh;

// Turns all within a ball of radius 0.35 about z, and less and less up to 0.85.
CarryPoints turn(double radians) {
  return [radians](double from, double to, std::span<Vec3d> points) {
    for (Vec3d& p : points) {
      const double t = std::min(1.0, std::max(0.0, (norm(p) - 0.35) / 0.5));
      if (t == 1) continue;
      const double angle = radians * (to - from) * (1 - t * t * (3 - 2 * t));
      p = {p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
    }
  };
}

std::vector<Vec3d> carried(const Volume& volume, const CarryPoints& carry) {
  std::vector<Vec3d> points = volume.points;
  carry(0, 1, points);
  return points;
}

bool is_on_box(const Vec3d& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) == 1; }

class FreePoints : public testing::TestWithParam<CellKind> {};

TEST_P(FreePoints, SaveTheCellsThatTheMotionInverts) {
  const Volume volume = box_of_cells(12, GetParam());
  const CarryPoints carry = turn(1.9);
  const DeformedCells deformed = deform_cells(volume.cells, volume.points, carry);
  EXPECT_GT(deformed.flow.inverted, 0U);
  EXPECT_EQ(deformed.result.inverted, 0U);
  EXPECT_GE(deformed.result.least_scaled_jacobian, 0.05);
  if (GetParam() == CellKind::tetrahedron) {  // hexahedra have eight corners to improve, and change more
    EXPECT_LT(deformed.result.mean_volume_change, 2 * deformed.flow.mean_volume_change);
  }

  const CellChanges changes = compare_cells(volume.cells, volume.points, deformed.points);
  EXPECT_EQ(changes.inverted, 0U);
  const std::vector<Vec3d> whole = carried(volume, carry);
  std::size_t freed = 0;
  for (std::size_t v = 0; v < whole.size(); ++v) {
    if (deformed.points[v] == whole[v]) continue;
    ++freed;
    EXPECT_FALSE(is_on_box(volume.points[v]));
    EXPECT_LT(norm(volume.points[v]), 0.85);
  }
  EXPECT_GT(freed, 0U);
  EXPECT_LE(freed, deformed.freed);
}

TEST_P(FreePoints, HaveTheSameBitsForEveryNumberOfThreads) {
  const Volume volume = box_of_cells(12, GetParam());
  CellOptions options;
  options.threads = 1;
  const DeformedCells one = deform_cells(volume.cells, volume.points, turn(2.2), options);
  options.threads = 3;
  const DeformedCells three = deform_cells(volume.cells, volume.points, turn(2.2), options);
  EXPECT_GT(one.freed, 0U);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.parts, three.parts);
}

TEST_P(FreePoints, AreNotTheFixedOnes) {
  const Volume volume = box_of_cells(12, GetParam());
  const CarryPoints carry = turn(1.9);
  const std::vector<Vec3d> whole = carried(volume, carry);
  std::vector<std::uint8_t> fixed(volume.points.size());
  for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = volume.points[v].x > 0 ? 1 : 0;
  CellOptions options;
  options.fixed = fixed;
  const DeformedCells half = deform_cells(volume.cells, volume.points, carry, options);
  EXPECT_GT(half.freed, 0U);
  EXPECT_LE(half.result.inverted, half.flow.inverted);
  for (std::size_t v = 0; v < fixed.size(); ++v) {
    if (fixed[v] != 0) {
      EXPECT_EQ(half.points[v], whole[v]);
    }
  }
  fixed.assign(fixed.size(), 1);
  const DeformedCells none = deform_cells(volume.cells, volume.points, carry, options);
  EXPECT_EQ(none.freed, 0U);
  EXPECT_EQ(none.points, whole);
  EXPECT_EQ(none.result.inverted, none.flow.inverted);
}

TEST_P(FreePoints, StayWhereNoCellIsBad) {
  const Volume volume = box_of_cells(8, GetParam());
  const DeformedCells deformed = deform_cells(volume.cells, volume.points, turn(0.1));
  EXPECT_EQ(deformed.freed, 0U);
  EXPECT_EQ(deformed.points, carried(volume, turn(0.1)));
}

INSTANTIATE_TEST_SUITE_P(Kinds, FreePoints, testing::Values(CellKind::tetrahedron, CellKind::hexahedron),
                         testing::PrintToStringParamName());

TEST(DeformCells, RefuseWhatIsOutOfRange) {
  const Volume volume = box_of_cells(2, CellKind::tetrahedron);
  CellOptions options;
  for (const double bad : {0.0, -1.0, 0.6, std::nan("")}) {
    options.least_scaled_jacobian = bad;
    EXPECT_THROW(deform_cells(volume.cells, volume.points, turn(1), options), InvalidInput);
  }
  options = {};
  const std::vector<std::uint8_t> fixed(3);
  options.fixed = fixed;
  EXPECT_THROW(deform_cells(volume.cells, volume.points, turn(1), options), InvalidInput);
  EXPECT_THROW(deform_cells(volume.cells, std::span(volume.points).first(5), turn(1)), InvalidInput);
}

TEST(DeformCells, CanBeCancelled) {
  const Volume volume = box_of_cells(12, CellKind::tetrahedron);
  Progress progress;
  progress.cancel = true;
  CellOptions options;
  options.progress = &progress;
  EXPECT_THROW(deform_cells(volume.cells, volume.points, turn(2), options), Cancelled);
}

}  // namespace
}  // namespace knead::cells_test
