// Cells that a flow would invert: points inside the mesh make way, or the session is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "support/volume_mesh.h"

namespace knead::kept_cells_test {
namespace {

// A box with layers at one side that are 1 / 50 of the others in height.
struct Layers {
  test::VolumeMesh volume;
  Mesh mesh;
  std::shared_ptr<VolumeCells> cells = std::make_shared<VolumeCells>();

  explicit Layers(double size = 1, CellKind kind = CellKind::tetrahedron) : volume(test::box_of_cells(8, kind)) {
    for (Vec3d& p : volume.points) {
      p.z = std::expm1(2 * (p.z + 1)) / std::expm1(4) * 2 - 1;
      p *= size;
    }
    mesh.positions = volume.points;
    cells->cells = volume.cells;
  }

  Session session(const std::string& line, const std::string& walls = "") const {
    return on_walls(parse_session("{\"knead\": 1" + walls + "}\n" + line, "s.knead"), {{floor()}}, mesh.positions,
                    {1, nullptr, cells});
  }

  // The side with the layers.
  Patch floor() const {
    Patch patch{"floor", {}};
    for (const CellBoundaryFace& face : boundary_faces(cells->cells, mesh.positions.size())) {
      const Triangle t{face[0], face[1], face[2]};
      if (mesh.positions[t[0]].z + mesh.positions[t[1]].z + mesh.positions[t[2]].z > -2.9999) continue;
      patch.faces.push_back(t);
      patch.points.insert(patch.points.end(), t.begin(), t.end());
      if (face[3] == kNoCorner) continue;
      patch.faces.push_back({face[1], face[3], face[2]});  // corners ascend, so that these are the other half
      patch.points.push_back(face[3]);
    }
    std::sort(patch.points.begin(), patch.points.end());
    patch.points.erase(std::unique(patch.points.begin(), patch.points.end()), patch.points.end());
    return patch;
  }
};

std::string turn(double degrees, double size = 1) {
  return "{\"tool\": \"rotate\", \"center\": [0, 0, 0], \"axis\": [1, 0.3, 0], \"inner\": " +
         std::to_string(0.05 * size) + ", \"outer\": " + std::to_string(0.9 * size) +
         ", \"angle_deg\": " + std::to_string(degrees) + "}\n";
}

TEST(KeptCells, PointsInsideMakeWay) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    const Layers layers(size);
    const std::string line = turn(100, size);
    const std::vector<Vec3d> flowed =
        replay(layers.mesh, parse_session("{\"knead\": 1}\n" + line, "s")).shape.positions();
    ASSERT_GT(count_inverted_since(*layers.cells, layers.mesh.positions, flowed), 0U) << size;
    const ReplayResult result = replay(layers.mesh, layers.session(line));
    const std::vector<Vec3d>& kept = result.shape.positions();
    EXPECT_EQ(count_inverted_since(*layers.cells, layers.mesh.positions, kept), 0U) << size;
    ASSERT_EQ(result.warnings.size(), 1U);
    EXPECT_NE(result.warnings[0].find("leave the flow"), std::string::npos) << result.warnings[0];
    for (const std::uint32_t v : boundary_points(layers.cells->cells, kept.size())) ASSERT_EQ(kept[v], flowed[v]);
  }
}

TEST(KeptCells, WhatInvertsNothingKeepsItsBits) {
  const Layers layers;
  const ReplayResult result = replay(layers.mesh, layers.session(turn(10)));
  EXPECT_EQ(result.shape.positions(),
            replay(layers.mesh, parse_session("{\"knead\": 1}\n" + turn(10), "s")).shape.positions());
  EXPECT_TRUE(result.warnings.empty());
}

TEST(KeptCells, WhatStaysInvertedIsRefused) {
  const Layers layers;
  layers.cells->on_surfaces.resize(layers.mesh.positions.size());
  for (std::uint32_t v = 0; v < layers.cells->on_surfaces.size(); ++v) layers.cells->on_surfaces[v] = v;
  try {
    replay(layers.mesh, layers.session(turn(100)));
    FAIL();
  } catch (const QualityLimit& error) {
    EXPECT_NE(std::string(error.what()).find("cells would be inverted"), std::string::npos) << error.what();
  }
}

TEST(KeptCells, EveryFrameKeepsThem) {
  const Layers layers;
  ReplayOptions options;
  options.frames.count = 4;
  int frames = 0;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    EXPECT_EQ(count_inverted_since(*layers.cells, layers.mesh.positions, frame.shape.positions()), 0U) << frame.index;
    ++frames;
  };
  const ReplayResult result = replay(layers.mesh, layers.session(turn(100)), options);
  EXPECT_EQ(frames, 4);
  EXPECT_EQ(result.warnings.size(), 1U);
}

// A wall that moves takes the cells beside it along, but not where they would be worse for it.
TEST(KeptCells, LayersNeverMakeThemWorse) {
  const Layers layers(1, CellKind::hexahedron);
  const auto moved = [&](double degrees, const std::string& walls) {
    const std::string line =
        "{\"tool\": \"rotate\", \"center\": [0, 0, -0.8], \"axis\": [0.2, 1, 0.1], \"inner\": 0.2, \"outer\": 0.9, "
        "\"angle_deg\": " +
        std::to_string(degrees) + "}\n";
    return replay(layers.mesh, layers.session(line, walls)).shape.positions();
  };
  for (const double degrees : {10.0, 25.0, 40.0}) {
    const std::vector<Vec3d> plain = moved(degrees, "");
    const CellCheck expected = check_cells(*layers.cells, plain);
    for (const char* width : {"0.2", "0.6", "1.2"}) {
      const std::vector<Vec3d> kept = moved(
          degrees, ", \"walls\": [{\"patch\": \"floor\", \"layers\": true, \"width\": " + std::string(width) + "}]");
      const CellCheck check = check_cells(*layers.cells, kept);
      EXPECT_LE(check.inverted, expected.inverted) << degrees << " " << width;
      EXPECT_LE(check.max_non_orthogonality_deg, expected.max_non_orthogonality_deg + 1e-3) << degrees << " " << width;
    }
  }
}

TEST(KeptCells, TheSameBitsForEveryNumberOfThreads) {
  const Layers layers;
  ReplayOptions options;
  options.motion.threads = 1;
  const std::vector<Vec3d> one = replay(layers.mesh, layers.session(turn(100)), options).shape.positions();
  options.motion.threads = 3;
  EXPECT_EQ(replay(layers.mesh, layers.session(turn(100)), options).shape.positions(), one);
}

}  // namespace
}  // namespace knead::kept_cells_test
