#include "knead/tool/stroke.h"

#include <gtest/gtest.h>

#include <vector>

#include "knead/flow/advect.h"
#include "knead/math/error.h"
#include "knead/mesh/shapes.h"

namespace knead {
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
}  // namespace knead
