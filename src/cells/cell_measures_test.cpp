// Volume, scaled Jacobian and orientation of cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "support/volume_mesh.h"

namespace knead::cell_measures_test {
namespace {

constexpr std::array kKinds{CellKind::tetrahedron, CellKind::pyramid, CellKind::wedge, CellKind::hexahedron};

// All edges are 1.
std::vector<Vec3d> regular(CellKind kind) {
  const double h = std::sqrt(3.0) / 2;
  switch (kind) {
    case CellKind::tetrahedron:
      return {{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {0.5, h / 3, std::sqrt(2.0 / 3)}};
    case CellKind::pyramid:
      return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, std::sqrt(0.5)}};
    case CellKind::wedge:
      return {{0, 0, 0}, {0.5, h, 0}, {1, 0, 0}, {0, 0, 1}, {0.5, h, 1}, {1, 0, 1}};
    case CellKind::hexahedron:
      return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  }
  return {};
}

double volume_of_regular(CellKind kind) {
  const std::array volumes{std::sqrt(2.0) / 12, std::sqrt(2.0) / 6, std::sqrt(3.0) / 4, 1.0};
  return volumes[static_cast<std::size_t>(kind)];
}

TEST(Cells, WithEqualEdgesAreTheBest) {
  for (const CellKind kind : kKinds) {
    const CellQuality quality = cell_quality(kind, regular(kind));
    EXPECT_NEAR(quality.volume, volume_of_regular(kind), 1e-15);
    EXPECT_NEAR(quality.scaled_jacobian, 1, 1e-15);
    EXPECT_EQ(quality.orientation, 1);
    EXPECT_EQ(corner_count(kind), regular(kind).size());
  }
}

// The volume grows with the determinant of a linear map, and a mirror turns the cell inside out.
TEST(Cells, FollowLinearMaps) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3d{number(random), number(random), number(random)}; };
  for (int i = 0; i < 200; ++i) {
    const Mat3d map{vector(), vector(), vector()};
    const Vec3d shift = vector() * 10;
    for (const CellKind kind : kKinds) {
      std::vector<Vec3d> corners = regular(kind);
      for (Vec3d& p : corners) p = map * p + shift;
      const CellQuality quality = cell_quality(kind, corners);
      EXPECT_NEAR(quality.volume, determinant(map) * volume_of_regular(kind), 1e-13);
      EXPECT_EQ(quality.orientation, determinant(map) > 0 ? 1 : -1);
      EXPECT_EQ(quality.scaled_jacobian > 0, determinant(map) > 0);
      EXPECT_LE(std::abs(quality.scaled_jacobian), 1 / volume_of_regular(CellKind::tetrahedron));
    }
  }
}

// Gauss's rule with two points along each axis is exact for the Jacobian of a trilinear map.
TEST(Cells, EncloseWhatATrilinearMapDoes) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-0.3, 0.3);
  for (int i = 0; i < 50; ++i) {
    std::vector<Vec3d> p = regular(CellKind::hexahedron);
    for (Vec3d& q : p) q += Vec3d{number(random), number(random), number(random)};
    const auto blend = [&](std::array<double, 8> w) {
      Vec3d sum{0, 0, 0};
      for (std::size_t k = 0; k < 8; ++k) sum += p[k] * w[k];
      return sum;
    };
    double volume = 0;
    for (int k = 0; k < 8; ++k) {
      const auto at = [&](int bit) { return 0.5 + ((k >> bit & 1) != 0 ? 0.5 : -0.5) / std::sqrt(3.0); };
      const double x = at(0);
      const double y = at(1);
      const double z = at(2);
      const double u = 1 - x;
      const double v = 1 - y;
      const double w = 1 - z;
      const Vec3d dx = blend({-v * w, v * w, y * w, -y * w, -v * z, v * z, y * z, -y * z});
      const Vec3d dy = blend({-u * w, -x * w, x * w, u * w, -u * z, -x * z, x * z, u * z});
      const Vec3d dz = blend({-u * v, -x * v, -x * y, -u * y, u * v, x * v, x * y, u * y});
      volume += dot(cross(dx, dy), dz) / 8;
    }
    EXPECT_NEAR(cell_quality(CellKind::hexahedron, p).volume, volume, 1e-14);
  }
}

TEST(Cells, ThatTurnAtOneCornerAreNoLongerOriented) {
  for (const CellKind kind : kKinds) {
    std::vector<Vec3d> corners = regular(kind);
    corners.front() += (corners.back() - corners.front()) * 1.5;
    const CellQuality quality = cell_quality(kind, corners);
    EXPECT_NE(quality.orientation, 1);
    EXPECT_LT(quality.scaled_jacobian, 0);
  }
}

// The determinant of doubles says nothing here: 1e-25 beside 1.
TEST(Cells, AreOrientedExactly) {
  std::vector<Vec3d> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1.0 / 3, 1.0 / 3, 0}};
  for (Vec3d& p : flat) p.z = 3 * p.x + 5 * p.y;
  EXPECT_EQ(cell_quality(CellKind::tetrahedron, flat).volume, 0);
  const double up = std::nextafter(flat[3].z, 10) - flat[3].z;
  flat[3].z += 2 * up;
  EXPECT_EQ(cell_quality(CellKind::tetrahedron, flat).orientation, 1);
  flat[3].z -= 4 * up;
  EXPECT_EQ(cell_quality(CellKind::tetrahedron, flat).orientation, -1);
}

TEST(Cells, WithoutSizeHaveNoOrientation) {
  for (const CellKind kind : kKinds) {
    const CellQuality quality = cell_quality(kind, std::vector<Vec3d>(corner_count(kind), {1, 2, 3}));
    EXPECT_EQ(quality.volume, 0);
    EXPECT_EQ(quality.scaled_jacobian, 0);
    EXPECT_EQ(quality.orientation, 0);
  }
}

// The cell of a kind, written as a hexahedron (or wedge) with corners given twice.
struct Collapsed {
  CellKind kind;
  CellKind written_as;
  std::vector<std::size_t> corners;  // of the cell that is meant
};

const Collapsed kCollapsed[] = {
    {CellKind::wedge, CellKind::hexahedron, {0, 2, 1, 1, 3, 5, 4, 4}},
    {CellKind::wedge, CellKind::hexahedron, {2, 2, 1, 0, 5, 5, 4, 3}},
    {CellKind::pyramid, CellKind::hexahedron, {0, 1, 2, 3, 4, 4, 4, 4}},
    {CellKind::pyramid, CellKind::hexahedron, {4, 4, 4, 4, 0, 3, 2, 1}},
    {CellKind::pyramid, CellKind::wedge, {0, 1, 4, 3, 2, 4}},
    {CellKind::tetrahedron, CellKind::hexahedron, {0, 1, 2, 2, 3, 3, 3, 3}},
    {CellKind::tetrahedron, CellKind::hexahedron, {0, 0, 1, 2, 3, 3, 3, 3}},
    {CellKind::tetrahedron, CellKind::wedge, {0, 2, 1, 3, 3, 3}},
};

TEST(Cells, WithCornersGivenTwiceAreTheCellsThatAreMeant) {
  for (std::size_t i = 0; i < std::size(kCollapsed); ++i) {
    const Collapsed& c = kCollapsed[i];
    for (const double side : {1.0, -1.0}) {
      std::vector<Vec3d> meant = regular(c.kind);
      for (Vec3d& p : meant) p = {side * p.x + 0.1 * p.y, 1.5 * p.y, p.z - 0.2 * p.x};
      std::vector<Vec3d> written;
      for (const std::size_t k : c.corners) written.push_back(meant[k]);
      const CellQuality expected = cell_quality(c.kind, meant);
      const CellQuality quality = cell_quality(c.written_as, written);
      EXPECT_NEAR(quality.volume, expected.volume, 1e-14) << i;
      EXPECT_NEAR(quality.scaled_jacobian, expected.scaled_jacobian, 1e-14) << i;
      EXPECT_EQ(quality.orientation, expected.orientation) << i;
      EXPECT_EQ(quality.orientation, side) << i;
    }
  }
}

TEST(Cells, WithOneEdgeCollapsedAreJudgedByTheOtherCorners) {
  std::vector<Vec3d> corners = regular(CellKind::hexahedron);
  corners[7] = corners[6];
  EXPECT_EQ(cell_quality(CellKind::hexahedron, corners).orientation, 1);
  EXPECT_GT(cell_quality(CellKind::hexahedron, corners).scaled_jacobian, 0.1);
  for (Vec3d& p : corners) p.x = -p.x;
  EXPECT_EQ(cell_quality(CellKind::hexahedron, corners).orientation, -1);
}

TEST(Cells, WithCornersGivenTwiceHaveNoBoundaryWhereTheyAreCollapsed) {
  Cells cells;  // two wedges as hexahedra, side by side: together a cube with the corners of its faces 0 1 2 3, 4 5 6 7
  cells.add(CellKind::hexahedron, std::vector<std::uint32_t>{0, 1, 2, 2, 4, 5, 6, 6});
  cells.add(CellKind::wedge, std::vector<std::uint32_t>{0, 3, 2, 4, 7, 6});
  const std::vector<CellBoundaryFace> faces = boundary_faces(cells, 8);
  EXPECT_EQ(faces.size(), 8u);  // four quadrilaterals, four triangles
  EXPECT_EQ(std::count_if(faces.begin(), faces.end(), [](const auto& f) { return f[3] == kNoCorner; }), 4);
}

TEST(Cells, RefuseWhatIsNoCell) {
  std::vector<Vec3d> corners = regular(CellKind::wedge);
  EXPECT_THROW(cell_quality(CellKind::hexahedron, corners), InvalidInput);
  corners[2].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cell_quality(CellKind::wedge, corners), InvalidInput);
}

Cells one_of_each(std::vector<Vec3d>& points) {
  Cells cells;
  for (const CellKind kind : kKinds) {
    std::vector<std::uint32_t> numbers;
    for (const Vec3d& p : regular(kind)) {
      numbers.push_back(static_cast<std::uint32_t>(points.size()));
      points.push_back(p);
    }
    cells.add(kind, numbers);
  }
  return cells;
}

TEST(Cells, AreComparedWithWhatTheyWere) {
  std::vector<Vec3d> before;
  const Cells cells = one_of_each(before);
  std::vector<Vec3d> after = before;
  for (Vec3d& p : after) p = {2 * p.x, 3 * p.y, 0.5 * p.z};
  CellChanges changes = compare_cells(cells, before, after);
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_NEAR(changes.volume_ratio[i], 3, 1e-14);
  EXPECT_EQ(changes.inverted, 0U);

  after[cells.corners_of(2)[0]].z += 3;  // the wedge
  changes = compare_cells(cells, before, after);
  EXPECT_EQ(changes.inverted, 1U);
  EXPECT_EQ(changes.is_inverted, (std::vector<std::uint8_t>{0, 0, 1, 0}));
  EXPECT_LT(changes.scaled_jacobian[2], 0);
}

// Cells that rest, move, turn inside out, and were flat, some with coordinates of 1e6.
TEST(Cells, AreTheSameWhatEverIsAskedFor) {
  std::mt19937 random(29);
  std::uniform_real_distribution<double> number(-0.6, 0.6);
  std::vector<Vec3d> before;
  Cells cells;
  for (int i = 0; i < 200; ++i) {
    for (const CellKind kind : kKinds) {
      std::vector<std::uint32_t> numbers;
      for (const Vec3d& p : regular(kind)) {
        numbers.push_back(static_cast<std::uint32_t>(before.size()));
        before.push_back({p.x, i % 10 == 0 ? 0 : p.y, p.z + 1e6 * (i % 3)});
      }
      cells.add(kind, numbers);
    }
  }
  std::vector<Vec3d> after = before;
  for (std::size_t v = 0; v < after.size() / 2; ++v) after[v] += Vec3d{number(random), number(random), number(random)};
  const CellChanges all = compare_cells(cells, before, after);
  EXPECT_GT(all.inverted, 50U);
  for (const int threads : {1, 3}) {
    const CellChanges few = compare_cells(cells, before, after, threads, CellValues::inversions);
    EXPECT_EQ(few.is_inverted, all.is_inverted);
    EXPECT_EQ(few.inverted, all.inverted);
    EXPECT_TRUE(few.volume_ratio.empty() && few.scaled_jacobian.empty());
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {  // each for itself
    std::vector<Vec3d> old;
    std::vector<Vec3d> now;
    for (const std::uint32_t corner : cells.corners_of(i)) {
      old.push_back(before[corner]);
      now.push_back(after[corner]);
    }
    const CellQuality was = cell_quality(cells.kinds[i], old);
    const CellQuality is = cell_quality(cells.kinds[i], now);
    const double ratio = is.volume / was.volume;
    EXPECT_TRUE(all.volume_ratio[i] == ratio || (std::isnan(ratio) && std::isnan(all.volume_ratio[i])));
    EXPECT_EQ(all.scaled_jacobian[i], was.orientation == -1 ? -is.scaled_jacobian : is.scaled_jacobian);
    EXPECT_EQ(all.is_inverted[i] != 0, was.orientation != 0 && is.orientation != was.orientation);
  }
}

// A mirror of both is no inversion; a flat cell cannot be inverted.
TEST(Cells, AreInvertedOnlyIfTheyTurned) {
  std::vector<Vec3d> before;
  const Cells cells = one_of_each(before);
  for (Vec3d& p : before) p.z = -p.z;
  const CellChanges same = compare_cells(cells, before, before);
  EXPECT_EQ(same.inverted, 0U);
  for (const double jacobian : same.scaled_jacobian) EXPECT_NEAR(jacobian, 1, 1e-15);

  const std::vector<Vec3d> mirrored_back = [&] {
    std::vector<Vec3d> points = before;
    for (Vec3d& p : points) p.z = -p.z;
    return points;
  }();
  EXPECT_EQ(compare_cells(cells, before, mirrored_back).inverted, cells.size());
  const std::vector<Vec3d> flat(before.size(), {1, 2, 3});
  EXPECT_EQ(compare_cells(cells, flat, before).inverted, 0U);
  EXPECT_THROW(compare_cells(cells, before, std::span(before).first(3)), InvalidInput);
}

TEST(Cells, OfAnyFacesHaveAVolume) {
  std::vector<Vec3d> points = regular(CellKind::hexahedron);
  const std::vector<std::uint32_t> faces{4, 0, 3, 2, 1, 4, 4, 5, 6, 7, 4, 0, 1, 5, 4,
                                         4, 1, 2, 6, 5, 4, 2, 3, 7, 6, 4, 3, 0, 4, 7};
  EXPECT_NEAR(polyhedron_volume(faces, points), 1, 1e-15);
  for (Vec3d& p : points) p = {p.x + 1e6, -2 * p.y, p.z - 1e6};
  EXPECT_NEAR(polyhedron_volume(faces, points), -2, 1e-9);
  EXPECT_EQ(polyhedron_volume({}, points), 0);
  EXPECT_EQ(polyhedron_orientation({}, points), 0);
  EXPECT_THROW(polyhedron_volume(std::span(faces).first(8), points), InvalidInput);
  EXPECT_THROW(polyhedron_volume(faces, std::span(points).first(7)), InvalidInput);
}

// One corner pushed through the opposite faces: the volume stays above 0, but two or more faces look the wrong way.
TEST(Polyhedra, AreTangledInAPart) {
  const std::vector<std::uint32_t> faces{4, 0, 3, 2, 1, 4, 4, 5, 6, 7, 4, 0, 1, 5, 4,
                                         4, 1, 2, 6, 5, 4, 2, 3, 7, 6, 4, 3, 0, 4, 7};
  std::vector<Vec3d> points = regular(CellKind::hexahedron);
  EXPECT_EQ(polyhedron_orientation(faces, points), 1);
  points[6] = {-0.2, -0.2, -0.2};
  EXPECT_GT(polyhedron_volume(faces, points), 0);
  EXPECT_EQ(polyhedron_orientation(faces, points), 0);
  points = regular(CellKind::hexahedron);
  for (Vec3d& p : points) p = Vec3d{1e6, 0, 0} + Vec3d{-p.x, p.y, 0.01 * p.z};
  EXPECT_EQ(polyhedron_orientation(faces, points), -1);
  EXPECT_THROW(polyhedron_orientation(std::span(faces).first(8), points), InvalidInput);
}

TEST(BoundaryPoints, AreThoseOnTheFacesOfOneCell) {
  for (const CellKind kind : {CellKind::tetrahedron, CellKind::hexahedron}) {
    const test::VolumeMesh box = test::box_of_cells(5, kind);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t v = 0; v < box.points.size(); ++v) {
      const Vec3d& p = box.points[v];
      if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) == 1) expected.push_back(v);
    }
    EXPECT_EQ(boundary_points(box.cells, box.points.size(), 1), expected);
    EXPECT_EQ(boundary_points(box.cells, box.points.size(), 3), expected);
    const std::vector<CellBoundaryFace> faces = boundary_faces(box.cells, box.points.size(), 3);
    EXPECT_EQ(faces, boundary_faces(box.cells, box.points.size(), 1));
    EXPECT_TRUE(std::is_sorted(faces.begin(), faces.end()));
    EXPECT_EQ(faces.size(), (kind == CellKind::tetrahedron ? 2U : 1U) * 6 * 5 * 5);
    for (const CellBoundaryFace& face : faces) EXPECT_EQ(face.back() == kNoCorner, kind == CellKind::tetrahedron);
    // Without one inner cell, its corners are on the boundary, too.
    Cells open;
    const std::size_t middle = box.cells.size() / 2;
    for (std::size_t i = 0; i < box.cells.size(); ++i) {
      if (i != middle) open.add(kind, box.cells.corners_of(i));
    }
    const std::span<const std::uint32_t> corners = box.cells.corners_of(middle);
    expected.insert(expected.end(), corners.begin(), corners.end());
    std::sort(expected.begin(), expected.end());
    expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
    EXPECT_EQ(boundary_points(open, box.points.size()), expected);
    EXPECT_THROW(boundary_points(box.cells, box.points.size() - 1), InvalidInput);
  }
  EXPECT_TRUE(boundary_points({}, 3).empty());
}

// --- cells of two dimensions

const double kHeight = std::sqrt(0.75);

// An equilateral triangle, whose corners are given in either direction, and a square beside it.
struct FlatCells {
  std::vector<Vec3d> points{{0, 0, 2}, {1, 0, 2}, {0.5, kHeight, 2}, {0, -1, 2}, {1, -1, 2}};
  VolumeCells cells;

  explicit FlatCells(const std::array<std::uint32_t, 3>& triangle) {
    add_flat_cell(triangle, {}, points, cells);
    add_flat_cell(std::array<std::uint32_t, 4>{0, 1, 4, 3}, {}, points, cells);
  }
};

TEST(FlatCells, AreJudgedAsTheyLieInTheirPlane) {
  for (const auto& triangle : std::to_array<std::array<std::uint32_t, 3>>({{0, 1, 2}, {0, 2, 1}})) {
    const FlatCells flat(triangle);
    const CellCheck check = check_cells(flat.cells, flat.points);
    EXPECT_EQ(check.cells, 2U);
    EXPECT_EQ(check.inverted, 0U);
    EXPECT_NEAR(*check.least_scaled_jacobian, 1, 1e-12);
    EXPECT_NEAR(check.max_non_orthogonality_deg, 0, 1e-5);
    EXPECT_LT(check.max_skewness, 1e-6);
    EXPECT_NEAR(check.max_aspect_ratio, 1 / kHeight, 1e-12);
  }
}

TEST(FlatCells, AreInvertedIfACornerTurns) {
  FlatCells flat({0, 1, 2});
  flat.points[2].y = -0.1;  // through the opposite side
  EXPECT_EQ(inverted_cells(flat.cells, flat.points), (std::vector<std::uint8_t>{1, 0}));
  flat.points[2].y = 0;  // flat
  EXPECT_EQ(inverted_cells(flat.cells, flat.points), (std::vector<std::uint8_t>{1, 0}));
  flat.points[3] = {1.5, -0.1, 2};  // the square crosses itself
  EXPECT_EQ(inverted_cells(flat.cells, flat.points), (std::vector<std::uint8_t>{1, 1}));
}

TEST(FlatCells, OfTheSecondOrderAreJudgedByTheirMiddleNodes) {
  for (const std::size_t n : {3, 4}) {
    std::vector<Vec3d> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    points.resize(n);
    for (std::size_t k = 0; k < n; ++k) points.push_back((points[k] + points[(k + 1) % n]) * 0.5);
    std::vector<std::uint32_t> numbers(2 * n);
    std::iota(numbers.begin(), numbers.end(), 0U);
    VolumeCells cells;
    add_flat_cell(std::span(numbers).first(n), std::span(numbers).subspan(n), points, cells);
    EXPECT_EQ(inverted_cells(cells, points), std::vector<std::uint8_t>{0}) << n;
    points[n].y = n == 3 ? 0.45 : 1.2;  // the middle of the first edge comes near the others, or beyond
    EXPECT_EQ(inverted_cells(cells, points), std::vector<std::uint8_t>{1}) << n;
  }
}

TEST(FlatCells, RefuseNumbersThatAreNoPoints) {
  FlatCells flat({0, 1, 2});
  EXPECT_THROW(add_flat_cell(std::array<std::uint32_t, 3>{0, 1, 5}, {}, flat.points, flat.cells), InvalidInput);
  EXPECT_THROW(add_flat_cell(std::array<std::uint32_t, 2>{0, 1}, {}, flat.points, flat.cells), InvalidInput);
}

}  // namespace
}  // namespace knead::cell_measures_test
