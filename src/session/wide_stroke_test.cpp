// Strokes with the wide falloff and tapered ones on a sphere: what a first pull looks like.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"

namespace knead::wide_stroke_test {
namespace {

// Of 60,000 vertices; its facets lie up to 1e-4 within the sphere of radius 1.
const Mesh& sphere() {
  static const Mesh mesh = make_shape(ShapeKind::sphere, 60'000);
  return mesh;
}

std::string line(const std::string& keys) { return "{\"knead\": 1}\n{" + keys + "}\n"; }

std::vector<Vec3d> moved(const std::string& keys) {
  const ReplayResult result = replay(sphere(), parse_session(line(keys), "s.knead"));
  EXPECT_EQ(result.status, AdvectStatus::done);
  return result.shape.positions();
}

double deepest(const std::vector<Vec3d>& points) {
  double least = 1;
  for (const Vec3d& p : points) least = std::min(least, norm(p));
  return 1 - least;
}

double volume_change(const std::vector<Vec3d>& points) {
  Mesh mesh = sphere();
  const double before = measure(mesh).volume;
  mesh.positions = points;
  return std::abs(measure(mesh).volume / before - 1);
}

std::size_t crossings(const std::vector<Vec3d>& points) {
  static const std::vector<Triangle> triangles = triangulate(sphere());
  return self_intersections(triangles, points).count;
}

// How wide the shape is within `near` of its farthest point.
double width_of_tip(const std::vector<Vec3d>& points, double near) {
  const Vec3d tip =
      *std::max_element(points.begin(), points.end(), [](const Vec3d& a, const Vec3d& b) { return norm(a) < norm(b); });
  double widest = 0;
  for (const Vec3d& a : points) {
    if (norm(a - tip) > near) continue;
    for (const Vec3d& b : points) {
      if (norm(b - tip) <= near) widest = std::max(widest, norm(a - b));
    }
  }
  return widest;
}

const std::string kPull = R"("tool": "implicit", "path": [[0, 0, 1], [0, 0.25, 1.9]])";

TEST(WideStroke, AFirstPullLeavesNoCrater) {
  for (const char* const keys :
       {R"(, "falloff": "wide", "bump": 0.35, "outer": 1.4)", R"(, "falloff": "wide", "bump": 0.5)"}) {
    const std::vector<Vec3d> points = moved(kPull + keys);
    EXPECT_LT(deepest(points), 0.03) << keys;
    EXPECT_LT(volume_change(points), 5e-5) << keys;
    EXPECT_EQ(crossings(points), 0u) << keys;
  }
  EXPECT_GT(deepest(moved(kPull + R"(, "inner": 0.1455, "outer": 0.4157)")), 0.1) << "what the paper's blend leaves";
}

TEST(WideStroke, ATaperedPullIsAPointedHorn) {
  const std::vector<Vec3d> points = moved(kPull + R"(, "falloff": "wide", "bump": 0.45, "taper": 1)");
  EXPECT_LT(deepest(points), 0.03);
  EXPECT_LT(volume_change(points), 5e-5);
  EXPECT_EQ(crossings(points), 0u);
  EXPECT_LT(width_of_tip(points, 0.02), 0.03);
}

// Along an arc of the sphere; the rims rise 2.5 times as high as the groove is deep with the paper's blend.
TEST(WideStroke, AGrooveIsAsDeepAsAskedAndHasNoRims) {
  std::string path;
  for (int i = 0; i < 60; ++i) {
    const double t = -0.6 + 1.2 * i / 59;
    path += (path.empty() ? "[" : ", [") + std::to_string(std::sin(t)) + ", 0, " + std::to_string(std::cos(t)) + "]";
  }
  const std::vector<Vec3d> points =
      moved(R"("tool": "paint", "falloff": "wide", "bump": 0.14, "depth": 0.025, "path": [)" + path + "]");
  double low = 1;
  double high = 1;
  for (const Vec3d& p : points) {
    if (p.z <= 0 || std::abs(std::atan2(p.x, p.z)) > 0.3) continue;
    low = std::min(low, norm(p));
    high = std::max(high, norm(p));
  }
  EXPECT_NEAR(1 - low, 0.025, 0.0025);
  EXPECT_LT(high - 1, 0.3 * (1 - low));
  EXPECT_LT(volume_change(points), 5e-5);
}

TEST(WideStroke, ComesBackAndDoesNotDependOnThreads) {
  for (const char* const keys :
       {R"(, "falloff": "wide", "bump": 0.3)", R"(, "falloff": "wide", "bump": 0.3, "core": 0.5, "taper": 0.7)"}) {
    Session session = parse_session(line(kPull + keys), "s.knead");
    ReplayOptions options;
    options.motion.precision = Precision::float64;
    options.motion.relative_tolerance = 1e-11;
    options.motion.threads = 1;
    const std::vector<Vec3d> there = replay(sphere(), session, options).shape.positions();
    options.motion.threads = 3;
    EXPECT_EQ(replay(sphere(), session, options).shape.positions(), there);
    Mesh mesh = sphere();
    mesh.positions = there;
    options.part.direction = Direction::backwards;
    const std::vector<Vec3d> back = replay(mesh, session, options).shape.positions();
    double worst = 0;
    for (std::size_t i = 0; i < back.size(); ++i) worst = std::max(worst, norm(back[i] - sphere().positions[i]));
    EXPECT_LT(worst, 1e-8) << keys;
  }
}

}  // namespace
}  // namespace knead::wide_stroke_test
