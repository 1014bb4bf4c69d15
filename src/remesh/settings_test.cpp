// The settings of a remesh: defaults, ranges and messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/vec.h"

namespace knead::settings_test {
namespace {

TEST(RemeshSettings, DefaultsFollowTheShapesSize) {
  Mesh ball = make_shape(ShapeKind::sphere, 1000);
  const RemeshTargets targets = resolve({}, ball);
  const double diagonal = bounding_box(ball.positions).diagonal();
  EXPECT_EQ(targets.max_chord, kDefaultMaxChord * diagonal);
  EXPECT_NEAR(targets.max_angle, kDefaultMaxAngleDeg * std::numbers::pi / 180, 1e-15);
  EXPECT_LE(2 * targets.min_edge, targets.max_edge);
  EXPECT_GT(targets.min_edge, 0);
  for (Vec3d& p : ball.positions) p *= 1000;
  const RemeshTargets larger = resolve({}, ball);
  EXPECT_NEAR(larger.max_edge / targets.max_edge, 1000, 1e-9);
  EXPECT_NEAR(larger.min_edge / targets.min_edge, 1000, 1e-9);
}

TEST(RemeshSettings, TheMeanEdgeHasTheSameBitsForEveryOrderOfVertices) {
  const Mesh ball = make_shape(ShapeKind::hand, 4000);
  double sum = 0;  // of each edge from both sides
  Mesh backwards = ball;
  std::reverse(backwards.positions.begin(), backwards.positions.end());
  for (std::uint32_t& v : backwards.corner_vertex) v = static_cast<std::uint32_t>(ball.vertex_count()) - 1 - v;
  for (std::size_t f = 0; f < ball.face_count(); ++f) {
    const auto face = ball.face(f);
    for (std::size_t i = 0; i < 3; ++i) sum += norm(ball.positions[face[i]] - ball.positions[face[(i + 1) % 3]]);
  }
  const double least = resolve({}, ball).min_edge;
  EXPECT_EQ(resolve({}, backwards).min_edge, least);
  EXPECT_NEAR(4 * least * static_cast<double>(ball.corner_vertex.size()) / sum, 1, 1e-13);
}

TEST(RemeshSettings, VerticesMayGrowFiftyfoldAndToTwoMillion) {
  EXPECT_EQ(resolve({}, make_shape(ShapeKind::sphere, 642)).max_vertices, 2'000'000U);
  const Mesh fine = make_shape(ShapeKind::sphere, 60'000);
  EXPECT_EQ(resolve({}, fine).max_vertices, 50 * fine.vertex_count());
  RemeshSettings settings;
  settings.max_vertices = 700;
  EXPECT_EQ(resolve(settings, fine).max_vertices, 700U);
}

TEST(RemeshSettings, WhatIsGivenIsTaken) {
  RemeshSettings settings;
  settings.max_edge = 0.5;
  settings.max_angle_deg = 90;
  settings.max_chord = 0.01;
  settings.min_edge = 0.25;
  settings.iterations = 0;
  const RemeshTargets targets = resolve(settings, make_shape(ShapeKind::box, 100));
  EXPECT_EQ(targets.max_edge, 0.5);
  EXPECT_EQ(targets.min_edge, 0.25);
  EXPECT_EQ(targets.iterations, 0);
  EXPECT_NEAR(targets.max_angle, std::numbers::pi / 2, 1e-15);
}

TEST(RemeshSettings, WhatIsOutOfRangeIsRefusedByName) {
  const auto refuses = [](const RemeshSettings& settings, const std::string& key) {
    try {
      validate(settings);
      ADD_FAILURE() << key << " was taken";
    } catch (const InvalidInput& error) {
      EXPECT_EQ(std::string(error.what()).rfind("\"" + key + "\"", 0), 0U) << error.what();
    }
  };
  RemeshSettings settings;
  settings.max_edge = 0;
  refuses(settings, "max_edge");
  settings = {};
  settings.max_angle_deg = 181;
  refuses(settings, "max_angle_deg");
  settings = {};
  settings.max_vertices = 0;
  refuses(settings, "max_vertices");
  settings = {};
  settings.max_vertices = kMaxVertices + 1;
  refuses(settings, "max_vertices");
  settings = {};
  settings.max_chord = 1;
  refuses(settings, "max_chord");
  settings = {};
  settings.min_edge = -1;
  refuses(settings, "min_edge");
  settings = {};
  settings.iterations = 101;
  refuses(settings, "iterations");
  settings = {};
  settings.max_edge = 1;
  settings.min_edge = 0.6;
  refuses(settings, "min_edge");
}

}  // namespace
}  // namespace knead::settings_test
