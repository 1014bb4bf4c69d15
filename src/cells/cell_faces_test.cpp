// Non-orthogonality and skewness of cells, against values by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "cells/cells.h"
#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "support/volume_mesh.h"

namespace knead::cell_faces_test {
namespace {

using test::box_of_cells;
using test::VolumeMesh;

constexpr double kRounding = 1e-9;  // degrees; doubles resolve 1e-14

double greatest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

VolumeMesh shaken_box(CellKind kind) {
  VolumeMesh box = box_of_cells(4, kind);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-0.1, 0.1);
  for (Vec3d& p : box.points) p += {shift(random), shift(random), shift(random)};
  return box;
}

// The faces of hexahedra as those of polyhedra.
std::vector<std::vector<std::uint32_t>> as_polyhedra(const Cells& cells) {
  std::vector<std::vector<std::uint32_t>> all;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::vector<std::uint32_t>& faces = all.emplace_back();
    for (const CellFace& face : shape_of(cells.kinds[i]).faces) {
      faces.push_back(4);
      for (const std::uint8_t k : face) faces.push_back(cells.corners_of(i)[k]);
    }
  }
  return all;
}

TEST(CellFaces, CubesArePerfect) {
  const VolumeMesh box = box_of_cells(3, CellKind::hexahedron);
  const CellFaceQuality quality = cell_face_quality(box.cells, box.points);
  EXPECT_LT(greatest(quality.non_orthogonality_deg), kRounding);
  EXPECT_LT(greatest(quality.skewness), kRounding);
}

// In a sheared box the lines between the cells' centres go with the shear, through the faces' centres. At the boundary
// the foot of the normal lies beside the face's centre by the shear times half an edge, and a face reaches as far.
TEST(CellFaces, AShearGivesItsAngle) {
  for (const double shear : {0.1, 1.0, 3.0}) {
    VolumeMesh box = box_of_cells(3, CellKind::hexahedron);
    for (Vec3d& p : box.points) p.x += shear * p.z;
    const CellFaceQuality quality = cell_face_quality(box.cells, box.points);
    for (const double angle : quality.non_orthogonality_deg) {
      EXPECT_NEAR(angle, std::atan(shear) * 180 / std::numbers::pi, kRounding);
    }
    EXPECT_NEAR(quality.skewness[13], 0, kRounding) << "in the middle";
    EXPECT_NEAR(quality.skewness[4], shear, kRounding) << "in the middle of the lower side";
  }
}

// Two cubes with a common face, the upper one shifted as a whole but for that face. By hand: the centres of the cells
// are at the middles of the opposite faces' centres.
TEST(CellFaces, ALineThatPassesByAFaceIsSkew) {
  VolumeMesh two{{}, {}};
  for (const double z : {0.0, 1.0, 2.0}) {
    const double x = z == 1 ? 0.5 : 0;
    for (const auto& [u, v] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
      two.points.push_back({u + x, v, z});
    }
  }
  const std::array<std::uint32_t, 8> lower{0, 1, 2, 3, 4, 5, 6, 7};
  const std::array<std::uint32_t, 8> upper{4, 5, 6, 7, 8, 9, 10, 11};
  two.cells.add(CellKind::hexahedron, lower);
  two.cells.add(CellKind::hexahedron, upper);
  const CellFaceQuality quality = cell_face_quality(two.cells, two.points);
  // Centres (0.75, 0.5, 0.5) and (0.75, 0.5, 1.5); the face's is (1, 0.5, 1): off by 0.25, and the face reaches 0.5.
  // The outer faces are off by the same 0.25 from (0.75, 0.5): no worse.
  EXPECT_NEAR(quality.skewness[0], 0.5, kRounding);
  EXPECT_NEAR(quality.skewness[1], 0.5, kRounding);
  EXPECT_LT(greatest(quality.non_orthogonality_deg), kRounding);
}

TEST(CellFaces, PolyhedraHaveTheValuesOfTheirHexahedra) {
  const VolumeMesh box = shaken_box(CellKind::hexahedron);
  const CellFaceQuality expected = cell_face_quality(box.cells, box.points);
  EXPECT_GT(greatest(expected.non_orthogonality_deg), 5);
  const std::vector<std::vector<std::uint32_t>> faces = as_polyhedra(box.cells);
  const std::vector<std::span<const std::uint32_t>> polyhedra(faces.begin(), faces.end());
  const CellFaceQuality found = cell_face_quality({}, box.points, polyhedra);
  EXPECT_EQ(found.non_orthogonality_deg, expected.non_orthogonality_deg);
  EXPECT_EQ(found.skewness, expected.skewness);
}

TEST(CellFaces, AHexahedronAndAPolyhedronAreNeighbours) {
  const VolumeMesh box = shaken_box(CellKind::hexahedron);
  const CellFaceQuality expected = cell_face_quality(box.cells, box.points);
  Cells first;
  for (std::size_t i = 0; i < 20; ++i) first.add(box.cells.kinds[i], box.cells.corners_of(i));
  const std::vector<std::vector<std::uint32_t>> faces = as_polyhedra(box.cells);
  const std::vector<std::span<const std::uint32_t>> rest(faces.begin() + 20, faces.end());
  EXPECT_EQ(cell_face_quality(first, box.points, rest).non_orthogonality_deg, expected.non_orthogonality_deg);
}

TEST(CellFaces, AMirroredMeshHasTheSameValues) {
  for (const CellKind kind : {CellKind::hexahedron, CellKind::tetrahedron}) {
    VolumeMesh box = shaken_box(kind);
    const CellFaceQuality expected = cell_face_quality(box.cells, box.points);
    for (Vec3d& p : box.points) p.x = -p.x;
    const CellFaceQuality found = cell_face_quality(box.cells, box.points);
    for (std::size_t i = 0; i < box.cells.size(); ++i) {
      EXPECT_NEAR(found.non_orthogonality_deg[i], expected.non_orthogonality_deg[i], kRounding);
      EXPECT_NEAR(found.skewness[i], expected.skewness[i], kRounding);
    }
  }
}

TEST(CellFaces, TheSizeOfTheMeshAndTheThreadsDoNotMatter) {
  VolumeMesh box = shaken_box(CellKind::tetrahedron);
  const CellFaceQuality expected = cell_face_quality(box.cells, box.points, {}, 1);
  for (Vec3d& p : box.points) p = p * 0x1p-40;
  const CellFaceQuality found = cell_face_quality(box.cells, box.points, {}, 3);
  EXPECT_EQ(found.non_orthogonality_deg, expected.non_orthogonality_deg);
  EXPECT_EQ(found.skewness, expected.skewness);
}

// A cell that is folded over its neighbour: the line between the centres leaves through the wrong side.
TEST(CellFaces, AFoldedCellIsBeyondARightAngle) {
  VolumeMesh box = box_of_cells(3, CellKind::hexahedron);
  for (Vec3d& p : box.points) {
    if (p.z > 0.9) p.z = -0.9;  // the uppermost layer inside out
  }
  EXPECT_GT(greatest(cell_face_quality(box.cells, box.points).non_orthogonality_deg), 90);
}

TEST(CellFaces, CornersThatAreNoPointsAreRefused) {
  const VolumeMesh box = box_of_cells(1, CellKind::hexahedron);
  EXPECT_THROW(cell_face_quality(box.cells, std::span(box.points).first(7)), InvalidInput);
  const std::array<std::uint32_t, 3> cut{4, 0, 1};
  const std::span<const std::uint32_t> polyhedron(cut);
  EXPECT_THROW(cell_face_quality({}, box.points, {&polyhedron, 1}), InvalidInput);
}

TEST(CellFaces, ThinLayersAreUnresolvedInFloat) {
  const auto thin_box = [](double height) {
    VolumeMesh box = box_of_cells(2, CellKind::hexahedron);
    for (Vec3d& p : box.points) {
      if (p.z == 0) p.z = 1 - height;  // the upper layer, four cells, ends at z = 1
    }
    return box;
  };
  for (const double height : {1e-3, 2e-3}) {
    const VolumeMesh box = thin_box(height);
    EXPECT_EQ(count_cells_unresolved_in_float(box.cells, box.points), height < 1.2e-3 ? 4U : 0U) << height;
  }
}

}  // namespace
}  // namespace knead::cell_faces_test
