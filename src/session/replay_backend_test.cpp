// Replays whose vertices something else moves.
#include <gtest/gtest.h>

#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"

namespace knead::replay_backend_test {
namespace {

const char* const kTwoStrokes =
    R"({"knead": 1}
{"tool": "implicit", "inner": 0.3, "outer": 0.9, "path": [[0.9, 0, 0], [1.3, 0.2, 0], [1.5, 0.3, 0.1]]}
{"tool": "twist", "center": [0, 0, 0], "axis": [0, 1, 0], "rate_deg": 30, "inner": -0.5, "outer": 0.5}
)";

const char* const kReadingStroke =
    R"({"knead": 1}
{"tool": "implicit", "inner": 0.3, "outer": 0.9, "path": [[0.9, 0, 0], [1.3, 0.2, 0]]}
{"tool": "paint", "outer": 0.2, "depth": 0.05, "path": [[0, 1, 0], [0.2, 0.98, 0], [0.4, 0.9, 0]]}
)";

// advect, and how often it was called.
struct Counting {
  int calls = 0;

  Backend backend() {
    return [this](const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
      ++calls;
      return advect(flow, points, options);
    };
  }
};

TEST(ReplayBackend, MovesTheVerticesAndCountsTheirSteps) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 600);
  const Session session = parse_session(kTwoStrokes, "test.knead");
  const ReplayResult expected = replay(mesh, session);
  Counting counting;
  ReplayOptions options;
  options.motion.backend = counting.backend();
  const ReplayResult found = replay(mesh, session, options);
  EXPECT_EQ(counting.calls, 2);
  EXPECT_EQ(found.shape.positions(), expected.shape.positions());
  EXPECT_EQ(found.shape.steps(), expected.shape.steps());
  EXPECT_EQ(found.shape.work().accepted_steps, expected.shape.work().accepted_steps);
  EXPECT_EQ(found.warnings, expected.warnings);
}

// What a stroke finds on the surface is what it always finds, whoever moves the vertices.
TEST(ReplayBackend, StrokesReadTheSurfaceAsTheCpuGivesIt) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 600);
  const Session session = parse_session(kReadingStroke, "test.knead");
  const ReplayResult expected = replay(mesh, session);
  ReplayOptions options;
  options.motion.backend = [](const Flow& flow, std::span<Vec3d> points, const AdvectOptions& how) {
    const AdvectResult result = advect(flow, points, how);
    for (Vec3d& p : points) p.x += 1e-3;
    return result;
  };
  const ReplayResult found = replay(mesh, session, options);
  ASSERT_EQ(found.resolved.size(), expected.resolved.size());
  for (std::size_t i = 0; i < found.resolved.size(); ++i) {
    EXPECT_EQ(found.resolved[i].stroke, expected.resolved[i].stroke);
  }
  EXPECT_NE(found.shape.positions(), expected.shape.positions());
}

// Vertices, and the points that remeshing adds: with a backend that does what advect does the result is the same.
TEST(ReplayBackend, MovesAShapeThatIsRemeshed) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 300);
  const Session session = parse_session(kTwoStrokes, "test.knead");
  Counting counting;
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  const ReplayResult expected = replay(mesh, session, options);
  options.motion.backend = counting.backend();
  const ReplayResult found = replay(mesh, session, options);
  EXPECT_GT(counting.calls, 2);
  EXPECT_TRUE(found.shape.positions() == expected.shape.positions());
  EXPECT_EQ(found.shape.mesh().corner_vertex, expected.shape.mesh().corner_vertex);
  EXPECT_EQ(found.shape.steps(), expected.shape.steps());
  EXPECT_EQ(found.shape.work().accepted_steps, expected.shape.work().accepted_steps);
  EXPECT_EQ(found.warnings, expected.warnings);
}

TEST(ReplayBackend, WhatItCannotCarryEndsTheReplay) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 300);
  const Session session = parse_session(kTwoStrokes, "test.knead");
  int calls = 0;
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.motion.backend = [&](const Flow& flow, std::span<Vec3d> points, const AdvectOptions& how) {
    if (++calls == 1) return advect(flow, points, how);
    return AdvectResult{AdvectStatus::step_limit, 0, 0, 0};
  };
  const ReplayResult found = replay(mesh, session, options);
  EXPECT_EQ(found.status, AdvectStatus::step_limit);
  EXPECT_EQ(found.failed_line, 2U);
  EXPECT_TRUE(found.shape.positions().empty());
}

// A mask is said to be the CPU's once, not with every stroke and mask after it; a grid is the backend's.
TEST(ReplayBackend, SaysOnceWhatTheCpuDoes) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 300);
  const std::string grid = R"({"tool": "grid", "origin": [0, 1, 0], "spacing": 0.5, "counts": [1, 1, 1], )"
                           R"("coefficients": "AAAAAAAAAAAAAAAAAAAAAAAAAAAAANA/"})"
                           "\n";
  const std::string mask = R"({"mask": {"points": [[0, 1, 0]], "values": [1], "width": 0.2}})"
                           "\n";
  Counting counting;
  ReplayOptions options;
  options.motion.backend = counting.backend();
  const auto warnings_of = [&](const std::string& lines) {
    const auto all = replay(mesh, parse_session("{\"knead\": 1}\n" + lines, "test.knead"), options).warnings;
    std::vector<std::string> of_gpu;
    for (const std::string& line : all) {
      if (line.find("the GPU cannot") != std::string::npos) of_gpu.push_back(line);
    }
    return of_gpu;
  };
  EXPECT_TRUE(warnings_of(grid + grid).empty());
  const auto warnings = warnings_of(grid + mask + grid + mask + grid);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("test.knead:3: the GPU cannot evaluate a mask"), std::string::npos);
  const auto of_handles = warnings_of(
      R"({"tool": "handles", "full": [[0, 1, 0]], "zero": [[0, -1, 0]], "motion": {"translate": [0, 0.1, 0]}})");
  ASSERT_EQ(of_handles.size(), 1U);
  EXPECT_NE(of_handles[0].find("the GPU cannot evaluate handles"), std::string::npos);
}

TEST(ReplayBackend, WhatItCannotDoEndsTheReplay) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 300);
  const Session session = parse_session(kTwoStrokes, "test.knead");
  ReplayOptions options;
  options.motion.backend = [](const Flow&, std::span<Vec3d>, const AdvectOptions&) {
    return AdvectResult{AdvectStatus::step_limit, 0, 0, 0};
  };
  const ReplayResult found = replay(mesh, session, options);
  EXPECT_EQ(found.status, AdvectStatus::step_limit);
  EXPECT_EQ(found.failed_line, 2U);
}

}  // namespace
}  // namespace knead::replay_backend_test
