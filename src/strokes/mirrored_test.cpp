// Strokes that are mirrored or moved, and rigid motions.
#include "knead/stroke.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <vector>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "support/random_grids.h"

namespace knead::mirrored_test {
namespace {

std::vector<Stroke> one_of_each() {
  ImplicitStroke capsule{{{0.2, 0.9, 0.1}, {0.5, 1.2, 0}, {0.6, 1.1, 0.2}}, 0.2, 0.5};
  capsule.region = ImplicitRegion::capsule;
  capsule.half_axis = {0.1, 0.05, 0.2};
  capsule.gauge = 0.6;
  PaintStroke paint{0.4, 0.1, {{{0.6, 0.8, 0}, {0.6, 0.8, 0.1}}, {{0.8, 0.6, 0.1}, {1, 1, 0}}}};
  PointsStroke points;
  points.points = {{0.5, 0.5, 0.7}, {0.6, 0.5, 0.6}};
  points.curves = {{{0.1, 0.9, 0.3}, {0.2, 0.9, 0.4}, {0.4, 0.8, 0.3}}};
  points.outer = 0.4;
  points.displacements = {{0.1, 0.1, 0}, {0, 0.1, -0.1}};
  HandlesStroke pull;
  pull.full = {{0.9, 0.4, 0.1}};
  pull.zero = {{-0.9, 0.1, 0.3}, {0, -1, 0}};
  pull.motion = HandlesTranslation{{0.2, 0.1, 0.1}};
  HandlesStroke turn = pull;
  turn.motion = HandlesRotation{{0.2, 1, 0.1}, {0.1, 0, 0.2}, 30};
  TwistStroke twist{{0.1, 0, 0.2}, {0.2, 1, 0.1}, 70, -0.3, 0.4};
  TwistStroke leaning = twist;
  leaning.normal = Vec3d{0.3, 1, 0};
  leaning.gauge = 0.3;
  BendStroke bend;
  bend.center = {0.1, 0.2, 0};
  bend.axis = {0, 0.2, 1};
  bend.normal = {1, 0.2, -0.04};
  bend.angle_deg = 50;
  bend.extent = BendWidth{0.8};
  return {ImplicitStroke{{{0.9, 0.2, 0.3}, {1.2, 0.5, 0.3}}, 0.2, 0.7},
          capsule,
          paint,
          points,
          pull,
          turn,
          RotateStroke{{0.6, 0.5, 0.2}, {0.3, 1, 0.2}, 50, 0.3, 0.7, 0.4},
          StretchStroke{{0.6, 0.5, 0.2}, {0.3, 1, 0.2}, 1.5, 0.3, 0.7},
          twist,
          leaning,
          bend};
}

Vec3d image(Vec3d p, int axis) {
  p[static_cast<std::size_t>(axis)] *= -1;
  return p;
}

TEST(Mirrored, MovesTheMirrorImageOfAShapeToTheMirrorImageOfWhereItMovesTheShape) {
  const std::vector<Vec3d> start = make_shape(ShapeKind::sphere, 642).positions;
  AdvectOptions options;
  options.tolerance = 1e-10;
  options.precision = Precision::float64;
  for (const Stroke& stroke : one_of_each()) {
    std::vector<Vec3d> moved = start;
    advect(flow_of(stroke), moved, options);
    double most = 0;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3d> images;
      for (const Vec3d& p : start) images.push_back(image(p, axis));
      advect(flow_of(mirrored(stroke, axis)), images, options);
      for (std::size_t i = 0; i < start.size(); ++i) {
        EXPECT_LT(norm(images[i] - image(moved[i], axis)), 1e-7) << tool_name(stroke) << ", axis " << axis;
        most = std::max(most, norm(moved[i] - start[i]));
      }
      EXPECT_EQ(mirrored(mirrored(stroke, axis), axis), stroke);
    }
    EXPECT_GT(most, 0.02) << tool_name(stroke) << " must move something";
  }
}

// Numbers without rounding, so that the mirror image of the mirror image is the stroke itself.
GridStroke some_grid() {
  test::Random random(17);
  GridStroke stroke;
  stroke.grid = test::random_grid(random, true).grid;
  stroke.grid.origin = {-0.5, -0.25, -0.625};
  stroke.grid.spacing = 0.25;
  return stroke;
}

TEST(Mirrored, MovesPointsByAGridAsItsMirrorImage) {
  const std::vector<Vec3d> start = make_shape(ShapeKind::sphere, 642).positions;
  AdvectOptions options;
  options.tolerance = 1e-10;
  options.precision = Precision::float64;
  const GridStroke stroke = some_grid();
  std::vector<Vec3d> moved = start;
  advect(flow_of(stroke), moved, options);
  EXPECT_NE(moved, start);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Vec3d> images;
    for (const Vec3d& p : start) images.push_back(image(p, axis));
    advect(flow_of(mirrored(stroke, axis)), images, options);
    for (std::size_t i = 0; i < start.size(); ++i) EXPECT_LT(norm(images[i] - image(moved[i], axis)), 1e-12);
    EXPECT_EQ(mirrored(mirrored(stroke, axis), axis), Stroke(stroke));
  }
}

TEST(Transformed, MovesAndMirrorsAGridButTurnsNone) {
  const std::vector<Vec3d> start = make_shape(ShapeKind::sphere, 642).positions;
  AdvectOptions options;
  options.tolerance = 1e-10;
  options.precision = Precision::float64;
  const GridStroke stroke = some_grid();
  std::vector<Vec3d> moved = start;
  advect(flow_of(stroke), moved, options);
  const RigidMotion turn{{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}, {0, 0, 0.5}};  // by half a turn
  for (const RigidMotion& motion : {RigidMotion{{}, {1, 2, 3}}, reflection_in({0, 0.5, 0}, {0, 1, 0}), turn}) {
    std::vector<Vec3d> images;
    for (const Vec3d& p : start) images.push_back(motion(p));
    advect(flow_of(transformed(stroke, motion)), images, options);
    for (std::size_t i = 0; i < start.size(); ++i) EXPECT_LT(norm(images[i] - motion(moved[i])), 1e-11);
  }
  EXPECT_THROW(transformed(stroke, rotation_about({0, 0, 0}, {0, 0, 1}, 0.3)), InvalidInput);
}

// Turns about any axis, mirror images in any plane, and what these make together.
std::vector<RigidMotion> some_motions() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] {
    const double x = number(random);
    const double y = number(random);
    return Vec3d{x, y, number(random)};
  };
  std::vector<RigidMotion> motions;
  for (int i = 0; i < 6; ++i) {
    const RigidMotion turn = rotation_about(vector(), vector(), 3 * number(random));
    const RigidMotion mirror = reflection_in(vector(), vector());
    motions.insert(motions.end(), {turn, mirror, mirror * turn});
  }
  return motions;
}

TEST(Transformed, MovesAMovedShapeToTheMovedImageOfWhereTheStrokeMovesIt) {
  const std::vector<Vec3d> start = make_shape(ShapeKind::sphere, 162).positions;
  AdvectOptions options;
  options.tolerance = 1e-10;
  options.precision = Precision::float64;
  for (const Stroke& stroke : one_of_each()) {
    std::vector<Vec3d> moved = start;
    advect(flow_of(stroke), moved, options);
    for (const RigidMotion& motion : some_motions()) {
      std::vector<Vec3d> images;
      for (const Vec3d& p : start) images.push_back(motion(p));
      advect(flow_of(transformed(stroke, motion)), images, options);
      double worst = 0;
      for (std::size_t i = 0; i < start.size(); ++i) worst = std::max(worst, norm(images[i] - motion(moved[i])));
      EXPECT_LT(worst, 1e-7) << tool_name(stroke) << (is_reflection(motion) ? ", mirrored" : ", turned");
    }
  }
}

TEST(Transformed, InACoordinatePlaneIsTheSameAsMirrored) {
  for (const Stroke& stroke : one_of_each()) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d normal{0, 0, 0};
      normal[static_cast<std::size_t>(axis)] = 1;
      EXPECT_EQ(transformed(stroke, reflection_in({0, 0, 0}, normal)), mirrored(stroke, axis)) << tool_name(stroke);
    }
  }
}

TEST(Transformed, AStampsPoseFitsTheToolOrItsMirrorImageInX) {
  StampStroke stroke;
  stroke.mesh = "tool.ply";
  stroke.path = {{0.1, 1, 0.2}, {0.1, 0.8, 0.3}};
  stroke.pose = {{0.1, -0.4, 0.2}, {0.5, 0.1, 0}, {0, 0.1, 0.6}};
  const Vec3d p{0.3, 0.7, -0.2};  // of the tool
  for (const RigidMotion& motion : some_motions()) {
    const auto seen = std::get<StampStroke>(transformed(stroke, motion));
    const Vec3d of_image = is_reflection(motion) ? image(p, 0) : p;
    const Vec3d expected = motion(stroke.path[0] + stroke.pose * p);
    EXPECT_LT(norm(seen.path[0] + seen.pose * of_image - expected), 1e-14);
    EXPECT_NEAR(determinant(seen.pose), determinant(stroke.pose), 1e-14);
  }
}

TEST(RigidMotions, ReflectRotateAndFollowEachOther) {
  const RigidMotion mirror = reflection_in({1, 2, 3}, {0, 0, 2});
  EXPECT_TRUE(is_reflection(mirror));
  EXPECT_LT(norm(mirror({4, 5, 6}) - Vec3d{4, 5, 0}), 1e-15);
  const RigidMotion quarter = rotation_about({1, 0, 0}, {0, 0, 3}, std::numbers::pi / 2);
  EXPECT_FALSE(is_reflection(quarter));
  EXPECT_LT(norm(quarter({2, 0, 5}) - Vec3d{1, 1, 5}), 1e-15);
  EXPECT_LT(norm((mirror * quarter)({2, 0, 5}) - mirror(quarter({2, 0, 5}))), 1e-15);
  RigidMotion whole;
  for (int i = 0; i < 4; ++i) whole = quarter * whole;
  EXPECT_LT(norm(whole({0.3, 0.7, 0.1}) - Vec3d{0.3, 0.7, 0.1}), 1e-15);
}

TEST(Mirrored, AStampsPoseFitsTheMirrorImageOfItsTool) {
  StampStroke stroke;
  stroke.mesh = "tool.ply";
  stroke.path = {{0.1, 1, 0.2}, {0.1, 0.8, 0.3}};
  stroke.pose = {{0.1, -0.4, 0.2}, {0.5, 0.1, 0}, {0, 0.1, 0.6}};
  const Vec3d p{0.3, 0.7, -0.2};
  for (int axis = 0; axis < 3; ++axis) {
    const auto seen = std::get<StampStroke>(mirrored(stroke, axis));
    EXPECT_LT(norm(seen.pose * image(p, axis) - image(stroke.pose * p, axis)), 1e-15);
    EXPECT_EQ(seen.path[1], image(stroke.path[1], axis));
    EXPECT_NEAR(determinant(seen.pose), determinant(stroke.pose), 1e-15);
  }
}

TEST(Mirrored, RefusesMarksGivenByVertices) {
  HandlesStroke stroke;
  stroke.full_vertices = {1};
  stroke.zero_vertices = {2};
  EXPECT_THROW(mirrored(stroke, 0), InvalidInput);
}

}  // namespace
}  // namespace knead::mirrored_test
