// The shape that strokes deform, against replays and against itself.
#include "knead/replay.h"

#include <gtest/gtest.h>

#include "knead/error.h"
#include "knead/mesh.h"
#include "support/random_segments.h"

namespace knead::deformed_shape_test {
namespace {

// Two strokes that read no surface, one that does, and one that is remeshed.
std::vector<SessionStroke> strokes() {
  PaintStroke groove;
  groove.outer = 0.3;
  groove.depth = 0.05;
  groove.path = {{0, 1.2, -0.1}, {0, 1.2, 0.1}};
  std::vector<SessionStroke> result;
  result.push_back({ImplicitStroke{{{1, 0, 0}, {1.5, 0, 0}, {1.8, 0.2, 0}}, 0.2, 0.7}});
  result.push_back({groove});
  result.push_back({RotateStroke{{0, 1, 0}, {0, 1, 0}, 60, 0.2, 0.8}, 0, RemeshSettings{}});
  result.push_back({TwistStroke{{0, 0, 0}, {0, 1, 0}, 30, -0.5, 0.5}});
  return result;
}

std::shared_ptr<const Mesh> ball() { return std::make_shared<const Mesh>(make_shape(ShapeKind::sphere, 642)); }

void expect_same(const DeformedShape& a, const DeformedShape& b) {
  EXPECT_TRUE(a.positions() == b.positions());
  EXPECT_EQ(a.mesh().corner_vertex, b.mesh().corner_vertex);
  EXPECT_EQ(a.steps(), b.steps());
  EXPECT_EQ(a.touched(), b.touched());
  EXPECT_EQ(a.normals(), b.normals());
  EXPECT_EQ(a.work().accepted_steps, b.work().accepted_steps);
}

TEST(DeformedShape, HasTheBitsOfAReplayAfterEveryStroke) {
  Session session;
  DeformedShape shape(ball());
  std::vector<SessionStroke> parts;
  for (const SessionStroke& stroke : strokes()) {
    session.strokes.push_back(stroke);
    const StrokeOutcome outcome = shape.apply(stroke);
    ASSERT_EQ(outcome.status, AdvectStatus::done);
    parts.insert(parts.end(), outcome.parts.begin(), outcome.parts.end());
    const ReplayResult replayed = replay(ball(), session);
    expect_same(shape, replayed.shape);
    EXPECT_EQ(parts, replayed.resolved);
  }
  EXPECT_TRUE(shape.is_remeshed());
}

TEST(DeformedShape, CopiesAreIndependent) {
  const std::vector<SessionStroke> all = strokes();
  DeformedShape shape(ball());
  shape.apply(all[0]);
  DeformedShape copy = shape;
  const std::vector<Vec3d> before = shape.positions();
  copy.apply(all[2]);
  EXPECT_TRUE(shape.positions() == before);
  EXPECT_FALSE(shape.is_remeshed());
  shape.apply(all[2]);
  expect_same(shape, copy);
}

TEST(DeformedShape, GoesBackToEveryState) {
  const std::vector<SessionStroke> all = strokes();
  const auto mesh = ball();
  DeformedShape shape(mesh, {}, {}, mesh->positions);  // on a unit ball its own normals
  std::vector<ShapeState> states{shape.state()};
  std::vector<std::vector<Vec3d>> positions{shape.positions()};
  for (const SessionStroke& stroke : all) {
    shape.apply(stroke);
    states.push_back(shape.state(states.back()));
    positions.push_back(shape.positions());
  }
  for (const std::size_t i : {2U, 4U, 0U, 3U, 1U}) {
    shape.restore(states[i]);
    EXPECT_TRUE(shape.positions() == positions[i]);
    EXPECT_TRUE(shape.state(states[i]).is_same(states[i]));
    EXPECT_EQ(shape.normals(), states[i].normals);
    if (i == all.size()) continue;
    shape.apply(all[i]);
    EXPECT_TRUE(shape.positions() == positions[i + 1]);
  }
}

TEST(DeformedShape, SaysWhatItCannotTake) {
  const auto refusal = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "nothing";
  };
  MotionOptions motion;
  motion.relative_tolerance = 0;
  EXPECT_EQ(refusal([&] { DeformedShape(ball(), motion); }), "the tolerance must be a number greater than 0, got 0");
  EXPECT_EQ(refusal([] { DeformedShape(ball(), {}, {std::nullopt, {1, 2}}); }), "give a label for each face");
  EXPECT_EQ(refusal([] { DeformedShape(ball(), {}, {}, {{0, 0, 1}}); }), "give a normal for each vertex");
  for (const auto& [scale, reason] : {std::pair{1e200, "too large"}, std::pair{1e39, "too large"},
                                      std::pair{1e-200, "too small"}, std::pair{4e-16, "too small"}}) {
    Mesh mesh = *ball();
    for (Vec3d& p : mesh.positions) p = p * scale;
    const auto scaled = std::make_shared<const Mesh>(std::move(mesh));
    EXPECT_NE(refusal([&] { DeformedShape shape(scaled); }).find(reason), std::string::npos) << scale;
  }
  TwistStroke twist{{0, 0, 0}, {0, 1, 0}, 50, -0.5, 0.5};
  twist.radius = 0.5;
  DeformedShape shape(ball());
  EXPECT_TRUE(refusal([&] { shape.apply({twist}); }).find("would be torn") != std::string::npos);
}

// Down to the limit and up to it, a shape and its strokes are as small or large as the result.
TEST(DeformedShape, SizeDoesNotMatter) {
  const auto deformed = [](double scale) {
    Mesh mesh = *ball();
    for (Vec3d& p : mesh.positions) p = p * scale;
    const auto scaled = [&](std::vector<Vec3d> points) {
      for (Vec3d& p : points) p = p * scale;
      return points;
    };
    PaintStroke groove;
    groove.outer = 0.3 * scale;
    groove.depth = 0.05 * scale;
    groove.path = scaled({{0, 1.2, -0.1}, {0, 1.2, 0.1}});
    const BendStroke bend{Vec3d{0, 0.2, 0} * scale, {1, 0, 0}, {0, 1, 0}, 20, BendWidth{0.8 * scale}};
    DeformedShape shape(std::make_shared<const Mesh>(std::move(mesh)));
    for (const Stroke& stroke :
         {Stroke{ImplicitStroke{scaled({{1, 0, 0}, {1.5, 0, 0}}), 0.2 * scale, 0.7 * scale}}, Stroke{groove},
          Stroke{RotateStroke{{}, {0, 1, 0}, 60, 0.2 * scale, 0.8 * scale}}, Stroke{bend}}) {
      EXPECT_EQ(shape.apply({stroke}).status, AdvectStatus::done) << scale;
    }
    std::vector<Vec3d> result = shape.positions();
    for (Vec3d& p : result) p = p * (1 / scale);
    return result;
  };
  const std::vector<Vec3d> expected = deformed(1);
  EXPECT_GT(test::greatest_distance(expected, ball()->positions), 0.3);
  for (const double scale : {0x1p-50, 0x1p-30, 0x1p30, 0x1p58}) {
    EXPECT_LT(test::greatest_distance(deformed(scale), expected), 5e-5) << scale;
  }
}

TEST(DeformedShape, WithoutAMeshIsEmpty) {
  const DeformedShape shape;
  EXPECT_TRUE(shape.positions().empty());
  EXPECT_EQ(shape.mesh().face_count(), 0u);
  EXPECT_TRUE(shape.steps().empty());
}

}  // namespace
}  // namespace knead::deformed_shape_test
