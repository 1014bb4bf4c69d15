// What is true of every tool, for random strokes of it. A new tool is tested here as soon as it is described.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/session.h"
#include "support/test_meshes.h"
#include "support/tool_docs.h"
#include "surveys/random_strokes.h"

namespace knead::tools_test {
namespace {

constexpr int kStrokes = 4;

class EveryTool : public testing::TestWithParam<const Tool*> {
 protected:
  // Random strokes of the tool for a sphere, from one seed for each tool.
  std::vector<Stroke> strokes(const Mesh& sphere) const {
    std::mt19937_64 random(7);
    std::vector<Stroke> result;
    for (int i = 0; i < kStrokes; ++i) {
      result.push_back(
          surveys::random_stroke(std::string(GetParam()->name), sphere, sphere.positions, "stamp.ply", random));
    }
    return result;
  }
};

TEST_P(EveryTool, ReadsWhatItWrites) {
  for (const Stroke& stroke : strokes(make_shape(ShapeKind::sphere, 642))) {
    const std::string line = stroke_line(stroke);
    const Session session = parse_session("{\"knead\": 1}\n" + line + "\n", "line");
    EXPECT_EQ(session.strokes.at(0).stroke, stroke) << line;
    EXPECT_EQ(mirrored(mirrored(stroke, 1), 1), stroke) << line;
  }
}

TEST_P(EveryTool, KeepsVolumeAndComesBack) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 10242);
  AdvectOptions options;
  options.tolerance = 1e-7;
  options.precision = Precision::float64;
  for (const Stroke& stroke : strokes(sphere)) {
    if (reads_surface(stroke)) continue;
    const Flow flow = flow_of(stroke);
    std::vector<Vec3d> points = sphere.positions;
    ASSERT_EQ(advect(flow, points, options).status, AdvectStatus::done);
    const double volume = measure_volume_and_area(sphere, points).volume;
    // Of sampling: the edges are a twentieth of the radius, the narrowest tools as large.
    EXPECT_NEAR(volume / measure(sphere).volume, 1, 5e-3) << stroke_line(stroke);
    ASSERT_EQ(advect(inverse(flow), points, options).status, AdvectStatus::done);
    double worst = 0;
    for (std::size_t i = 0; i < points.size(); ++i) worst = std::fmax(worst, norm(points[i] - sphere.positions[i]));
    EXPECT_LT(worst, 1e-4) << stroke_line(stroke);  // the tolerance, grown by the flow there and back
  }
}

INSTANTIATE_TEST_SUITE_P(Tools, EveryTool, testing::ValuesIn(tools().begin(), tools().end()),
                         [](const auto& test) { return std::string(test.param->name); });

// One stroke of one segment for each tool that is a flow, for a sphere about `at`.
std::vector<Stroke> strokes_about(const Vec3d& at) {
  const std::vector<Vec3d> path{at, at + Vec3d{0.5, 0.25, 0}};
  HandlesStroke handles;
  handles.full = {at, at + Vec3d{0.25, 0, 0}};
  handles.zero = {at + Vec3d{1, 0, 0}, at - Vec3d{1, 0, 0}, at + Vec3d{0, 1, 0}};
  handles.motion = HandlesTranslation{{0.25, 0.125, 0}};
  const std::vector<Vec3d> nodes(64, {0.0625, -0.125, 0.25});
  const GridStroke grid{{at - Vec3d{0.75, 0.75, 0.75}, 0.5, {4, 4, 4}, SharedVectors(nodes), {}}};
  return {ImplicitStroke{path, 0.3, 1.0},
          PaintStroke{0.25, 0.05, {{at + Vec3d{0, 1, 0}, {0, 1, 0}}}},
          PointsStroke{path, {}, 0.8, {{0.5, 0.25, 0}}},
          handles,
          RotateStroke{at, {0, 0, 1}, 60, 0.25, 1.2},
          StretchStroke{at, {0, 0, 1}, 1.5, 0.25, 1.2},
          TwistStroke{at, {0, 0, 1}, 60, -0.5, 0.5},
          BendStroke{at, {1, 0, 0}, {0, 0, 1}, 40, BendWidth{1.5}},
          PinsStroke{{at, at + Vec3d{1, 0, 0}}, {at + Vec3d{0, 0.25, 0}, at + Vec3d{1, 0, 0}}, 1.25},
          grid};
}

// Coordinates of the sphere are multiples of 2^-20, so that shifting it rounds nothing.
TEST(Tools, GiveTheSameBitsFarFromTheOriginAfterTheShift) {
  const Vec3d far{5e6, -3e6, 4e6};
  std::vector<Vec3d> sphere = make_shape(ShapeKind::sphere, 2562).positions;
  for (Vec3d& p : sphere) {
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = std::round(p[axis] * 0x1p20) * 0x1p-20;
  }
  const std::vector<Stroke> near_strokes = strokes_about({0, 0, 0});
  const std::vector<Stroke> far_strokes = strokes_about(far);
  AdvectOptions options;
  options.tolerance = 1e-5;
  for (std::size_t i = 0; i < near_strokes.size(); ++i) {
    std::vector<Vec3d> here = sphere;
    std::vector<Vec3d> there = sphere;
    for (Vec3d& p : there) p = p + far;
    ASSERT_EQ(advect(flow_of(near_strokes[i]), here, options).status, AdvectStatus::done);
    ASSERT_EQ(advect(flow_of(far_strokes[i]), there, options).status, AdvectStatus::done);
    EXPECT_NE(here, sphere) << stroke_line(near_strokes[i]);
    for (Vec3d& p : here) p = p + far;
    EXPECT_EQ(here, there) << stroke_line(near_strokes[i]);
  }
}

TEST(Tools, AreAllDescribedInTheDocumentation) {
  const std::string document = file_bytes(std::filesystem::path(KNEAD_SOURCE) / "docs/session.md");
  for (const std::string& problem : test::documentation_problems(document)) ADD_FAILURE() << problem;
}

}  // namespace
}  // namespace knead::tools_test
