// Cells that a flow would invert: points inside the mesh make way, or the session is refused.
#include <gtest/gtest.h>

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
  test::VolumeMesh volume = test::box_of_cells(8, CellKind::tetrahedron);
  Mesh mesh;
  std::shared_ptr<VolumeCells> cells = std::make_shared<VolumeCells>();

  explicit Layers(double size = 1) {
    for (Vec3d& p : volume.points) {
      p.z = std::expm1(2 * (p.z + 1)) / std::expm1(4) * 2 - 1;
      p *= size;
    }
    mesh.positions = volume.points;
    cells->cells = volume.cells;
  }

  Session session(const std::string& line) const {
    return on_walls(parse_session("{\"knead\": 1}\n" + line, "s.knead"), {}, mesh.positions, {1, nullptr, cells});
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
