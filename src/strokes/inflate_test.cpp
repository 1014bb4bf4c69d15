// The tool "inflate": the volume that it adds, its reach, its inverse, and refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/body_points.h"
#include "strokes/pose.h"
#include "support/surface.h"

namespace knead::inflate_test {
namespace {

struct Inflated : test::MovedSurface {
  using MovedSurface::MovedSurface;

  bool inflate(const InflateStroke& stroke, int threads = 0) { return inflate_on(stroke, live(threads), threads); }
};

double gain_of(const Mesh& before, const Mesh& after) { return measure(after).volume - measure(before).volume; }

std::string error_of(const Mesh& mesh, const InflateStroke& stroke) {
  Inflated shape(mesh);
  try {
    shape.inflate(stroke);
  } catch (const InvalidInput& error) {
    EXPECT_EQ(shape.mesh.positions, mesh.positions);
    return error.what();
  }
  return "";
}

TEST(Inflate, DoesTheSameWhereverTheShapeIs) {
  const Mesh ball = make_shape(ShapeKind::sphere, 2562);
  const auto inflated = [&](const Vec3d& by) {
    Mesh moved = ball;
    for (Vec3d& p : moved.positions) p += by;
    Inflated shape(moved);
    EXPECT_TRUE(shape.inflate({{Vec3d{0, 0, 1} + by}, 0.5, 0.02}));
    for (Vec3d& p : shape.mesh.positions) p -= by;
    return shape.mesh.positions;
  };
  const std::vector<Vec3d> still = inflated({0, 0, 0});
  for (const Vec3d& by : {Vec3d{1, 0, 0}, Vec3d{0.013, 0.007, 0.003}, Vec3d{100, -3, 0}}) {
    const std::vector<Vec3d> moved = inflated(by);
    for (std::size_t i = 0; i < still.size(); ++i) EXPECT_LT(norm(moved[i] - still[i]), 1e-9) << by.x;
  }
}

TEST(Inflate, AddsTheVolumeThatIsTypedAndMovesNothingBeyondItsRadius) {
  const Mesh before = make_shape(ShapeKind::sphere, 2562);
  for (const double volume : {0.01, 0.05, -0.015}) {
    const InflateStroke stroke{{{0, 0, 1}}, 0.7, volume};
    Inflated shape(before);
    ASSERT_TRUE(shape.inflate(stroke));
    EXPECT_NEAR(gain_of(before, shape.mesh) / volume, 1, 1e-4);
    EXPECT_EQ(self_intersections(shape.triangles, shape.mesh.positions).count, 0U);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < before.vertex_count(); ++i) {
      const bool is_beyond = norm(before.positions[i] - stroke.points[0]) > stroke.radius;
      if (is_beyond) {
        EXPECT_EQ(shape.mesh.positions[i], before.positions[i]);
      }
      moved += shape.mesh.positions[i] == before.positions[i] ? 0 : 1;
      // Nothing beyond the radius comes within it, and nothing leaves it.
      EXPECT_LE(is_beyond ? 0 : norm(shape.mesh.positions[i] - stroke.points[0]), stroke.radius);
    }
    EXPECT_GT(moved, 100U);
    for (const Stroke& part : shape.applied) {
      EXPECT_TRUE(changes_volume(flow_of(part).segments.front()));
    }
  }
}

TEST(Inflate, MovesTheSurfaceAsFarAsIsTyped) {
  const Mesh before = make_shape(ShapeKind::sphere, 2562);
  for (const double depth : {0.02, 0.15, 0.3, -0.1}) {
    Inflated shape(before);
    for (Triangle& t : shape.triangles) std::swap(t[1], t[2]);
    ASSERT_TRUE(shape.inflate({.points = {{0, 0, 1}, {0.1, 0, 0.99}}, .radius = 0.5, .depth = depth}));
    double most = 0;
    for (std::size_t i = 0; i < before.vertex_count(); ++i) {
      most = std::max(most, norm(shape.mesh.positions[i] - before.positions[i]));
    }
    EXPECT_NEAR(most / std::abs(depth), 1, 2e-3) << depth;
    EXPECT_EQ(gain_of(before, shape.mesh) > 0, depth > 0);
    EXPECT_EQ(self_intersections(shape.triangles, shape.mesh.positions).count, 0U);
  }
  EXPECT_NE(error_of(before, {.points = {{0, 0, 1}}, .radius = 0.5, .depth = 0.45}).find("at most"), std::string::npos);
  const std::string both = error_of(before, {.points = {{0, 0, 1}}, .radius = 0.5, .volume = 0.01, .depth = 0.1});
  EXPECT_NE(both.find("leave one out"), std::string::npos) << both;
}

TEST(Inflate, GrowsAlongAPathOnAnInsideOutSurfaceToo) {
  Mesh before = make_shape(ShapeKind::sphere, 10242);
  const InflateStroke stroke{{{0, 0.1, 0.99}, {0.1, 0, 0.99}}, 0.4, 0.015};
  Inflated shape(before);
  ASSERT_TRUE(shape.inflate(stroke));
  EXPECT_NEAR(gain_of(before, shape.mesh) / stroke.volume, 1, 1e-4);
  for (const Vec3d& p : shape.mesh.positions) EXPECT_GT(norm(p), 0.97);
  Inflated turned(before);
  for (Triangle& t : turned.triangles) std::swap(t[1], t[2]);
  ASSERT_TRUE(turned.inflate(stroke));
  EXPECT_NEAR(gain_of(before, turned.mesh) / stroke.volume, 1, 1e-4);
}

// What a path line is stretched by is exactly what the certificate says, and the inverse takes it all back.
TEST(Inflate, IsADiffeomorphismThatComesBack) {
  const Mesh before = make_shape(ShapeKind::sphere, 2562);
  Inflated shape(before);
  ASSERT_TRUE(shape.inflate({{{0, 0, 1}}, 0.8, 0.1}));
  Flow flow;
  for (const Stroke& part : shape.applied) flow.segments.push_back(flow_of(part).segments.front());
  std::vector<Vec3d> points;
  for (const Vec3d& p : before.positions) {
    if (norm(p - Vec3d{0, 0, 1}) < 0.7) points.push_back(p);
  }
  AdvectOptions options;
  options.tolerance = 1e-9;
  options.precision = Precision::float64;
  double greatest = 0;
  for (const Mat3d& jacobian : jacobians(flow, points, options)) {
    EXPECT_GT(determinant(jacobian), 0.1);
    greatest = std::max(greatest, determinant(jacobian));
  }
  EXPECT_GT(greatest, 1.2);
  std::vector<Vec3d> there = points;
  advect(flow, there, options);
  advect(inverse(flow), there, options);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LE(norm(there[i] - points[i]), 1e-6);
}

// A ball is round about the place that grows: the grids leave no pattern that one would see in its shine.
TEST(Inflate, IsAsSmoothAsTheShape) {
  Inflated shape(make_shape(ShapeKind::sphere, 10242));
  ASSERT_TRUE(shape.inflate({{{0, 0, 1}}, 0.45, 0.02}));
  Flow flow;
  for (const Stroke& part : shape.applied) flow.segments.push_back(flow_of(part).segments.front());
  double highest = 0;
  for (const double sine : {0.0, 0.1, 0.2}) {
    std::vector<Vec3d> ring;
    for (int i = 0; i < 64; ++i) {
      const double angle = i * std::acos(-1) / 32;
      ring.push_back({sine * std::cos(angle), sine * std::sin(angle), std::sqrt(1 - sine * sine)});
    }
    advect(flow, ring, {.tolerance = 1e-7, .precision = Precision::float64});
    const auto [least, most] = std::minmax_element(ring.begin(), ring.end(),
                                                   [](const Vec3d& a, const Vec3d& b) { return norm2(a) < norm2(b); });
    highest = std::max(highest, norm(*most) - 1);
    EXPECT_LT(norm(*most) - norm(*least), 0.02 * highest) << sine;
  }
  EXPECT_GT(highest, 0.09);
}

TEST(Inflate, GivesTheSameBitsForEveryNumberOfThreadsAndOrder) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 2562);
  const InflateStroke stroke{{{0, 0, 1}}, 0.7, 0.05};
  Inflated one(mesh);
  one.inflate(stroke, 1);
  Inflated two(mesh);
  two.inflate(stroke, 2);
  EXPECT_EQ(one.applied, two.applied);
  Inflated reversed(mesh);
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  reversed.inflate(stroke);
  EXPECT_EQ(one.applied, reversed.applied);
}

TEST(Inflate, RefusesWhatCannotGrow) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 2562);
  EXPECT_NE(error_of(sphere, {{{0, 0, 3}}, 0.5, 0.1}).find("nothing of the shape's inside"), std::string::npos);
  EXPECT_NE(error_of(sphere, {{{0, 0, 0}}, 0.5, 0.1}).find("no surface"), std::string::npos);
  EXPECT_NE(error_of(sphere, {{{0, 0, 1}}, 0.5, 0.2}).find("at most"), std::string::npos);
  for (const double radius : {0.3, 0.41, 0.5, 0.6}) {
    const std::string message = error_of(sphere, {{{0, 0, 1}}, radius, -0.5});
    ASSERT_NE(message.find("taken away"), std::string::npos) << message;
    const double volume = std::stod(message.substr(message.find("at most ") + 8));
    EXPECT_EQ(error_of(sphere, {{{0, 0, 1}}, radius, -volume}).find("taken away"), std::string::npos) << message;
  }
  EXPECT_NE(error_of(sphere, {{}, 0.5, 0.1}).find("\"points\""), std::string::npos);
  EXPECT_EQ(error_of(sphere, {{{0, 0, 1}}, 0.5, 0}), "");
}

}  // namespace
}  // namespace knead::inflate_test
