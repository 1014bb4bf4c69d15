// What is true of every tool, for random strokes of it. A new tool is tested here as soon as it is described.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "acceptance/random_strokes.h"
#include "knead/flow/advect.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/shapes.h"
#include "knead/session/session.h"
#include "knead/tool/tool.h"
#include "support/test_meshes.h"
#include "support/tool_docs.h"

namespace knead {
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
          acceptance::random_stroke(std::string(GetParam()->name), sphere, sphere.positions, "stamp.ply", random));
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

TEST(Tools, AreAllDescribedInTheDocumentation) {
  const std::string document = file_bytes(std::filesystem::path(KNEAD_SOURCE) / "docs/session.md");
  for (const std::string& problem : test::documentation_problems(document)) ADD_FAILURE() << problem;
}

}  // namespace
}  // namespace knead
