// Cells of the second order, and cells against checkMesh.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "support/volume_mesh.h"

namespace knead::middle_nodes_test {
namespace {

constexpr std::array kKinds{CellKind::tetrahedron, CellKind::pyramid, CellKind::wedge, CellKind::hexahedron};

std::vector<Vec3d> right_angled(CellKind kind) {
  switch (kind) {
    case CellKind::tetrahedron:
      return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case CellKind::pyramid:
      return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0.7}};
    case CellKind::wedge:
      return {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
    case CellKind::hexahedron:
      return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  }
  return {};
}

// A cell with a node in the middle of each edge.
struct OneCell {
  std::vector<Vec3d> points;
  Cells cells;
  MiddleNodes middles;

  explicit OneCell(CellKind kind) : points(right_angled(kind)) {
    std::vector<std::uint32_t> corners(points.size());
    for (std::uint32_t i = 0; i < corners.size(); ++i) corners[i] = i;
    cells.add(kind, corners);
    middles.cells = {0};
    for (const auto& [a, b] : edges_of(kind)) {
      middles.points.push_back(static_cast<std::uint32_t>(points.size()));
      points.push_back((points[a] + points[b]) * 0.5);
    }
    middles.first = {0, middles.points.size()};
  }
  double least() const { return middle_jacobians(cells, middles, points).front(); }
};

TEST(MiddleNodes, StraightEdgesGiveTheLinearCellsValue) {
  for (const CellKind kind : kKinds) {
    const OneCell cell(kind);
    const double linear = cell_quality(kind, std::span(cell.points).first(corner_count(kind))).scaled_jacobian;
    EXPECT_NEAR(cell.least(), linear, 0.25 * linear) << static_cast<int>(kind);
    EXPECT_GT(cell.least(), 0.2);
  }
}

// A middle node that is moved beyond a quarter of its edge folds the edge: the map leaves the corner backwards there.
TEST(MiddleNodes, OneBeyondAQuarterOfItsEdgeFoldsTheCell) {
  for (const CellKind kind : kKinds) {
    const std::size_t edges = edges_of(kind).size();
    for (std::size_t e = 0; e < edges; ++e) {
      if (kind == CellKind::pyramid && edges_of(kind)[e][1] == 4) continue;  // its other end is the apex
      OneCell cell(kind);
      const auto [a, b] = edges_of(kind)[e];
      for (const double t : {0.3, 0.7}) {
        cell.points[cell.middles.points[e]] = cell.points[a] * (1 - t) + cell.points[b] * t;
        EXPECT_GT(cell.least(), 0) << static_cast<int>(kind) << ' ' << e << ' ' << t;
      }
      for (const double t : {0.2, 0.8}) {
        cell.points[cell.middles.points[e]] = cell.points[a] * (1 - t) + cell.points[b] * t;
        EXPECT_LT(cell.least(), 0) << static_cast<int>(kind) << ' ' << e << ' ' << t;
      }
    }
  }
}

TEST(MiddleNodes, OneThatIsPushedInFoldsTheCell) {
  OneCell cell(CellKind::hexahedron);
  Vec3d& middle = cell.points[cell.middles.points[0]];  // of the edge from (0, 0, 0) to (1, 0, 0)
  middle.z = 0.4;
  EXPECT_GT(cell.least(), 0);
  middle.z = 1.1;  // beyond the opposite edge
  EXPECT_LT(cell.least(), 0);
}

TEST(MiddleNodes, NumbersThatAreNoPointsAreRefused) {
  const OneCell cell(CellKind::wedge);
  EXPECT_THROW(middle_jacobians(cell.cells, cell.middles, std::span(cell.points).first(8)), InvalidInput);
}

// What checkMesh of OpenFOAM 1912 said of these meshes (tests/agreement/checkmesh_test.sh asks it where it is
// installed).
TEST(CheckMesh, FiguresAgree) {
  struct Case {
    CellKind kind;
    double non_orthogonality, mean, skewness, aspect_ratio;
  };
  for (const Case& of :
       {Case{CellKind::hexahedron, 43.318678945299851, 22.482180152031372, 2.3092682984637798, 6.5938455546781656},
        Case{CellKind::tetrahedron, 80.532976060101277, 54.877981959616548, 1.1402007479214342, 10.44879824642392}}) {
    test::VolumeMesh box = test::box_of_cells(4, of.kind);
    for (Vec3d& p : box.points) {
      p = {p.x + 0.1 * std::sin(7 * p.x + 3 * p.y), p.y + 0.1 * std::cos(5 * p.y + 2 * p.z),
           0.2 * p.z + 0.02 * std::sin(4 * p.z + 6 * p.x)};
    }
    const CellFaceQuality found = cell_face_quality(box.cells, box.points);
    const auto greatest = [](const std::vector<double>& values) { return *std::ranges::max_element(values); };
    EXPECT_NEAR(greatest(found.non_orthogonality_deg), of.non_orthogonality, 1e-9);
    EXPECT_NEAR(found.mean_non_orthogonality_deg, of.mean, 1e-9);
    EXPECT_NEAR(greatest(found.skewness), of.skewness, 1e-12);
    EXPECT_NEAR(greatest(found.aspect_ratio), of.aspect_ratio, 1e-11);
  }
}

}  // namespace
}  // namespace knead::middle_nodes_test
