// The moments of frames: durations, ease, hold, and frames with the faces of a remeshed result.
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::frames_test {
namespace {

constexpr const char* kStrokes[] = {
    R"({"tool": "implicit", "inner": 0.2, "outer": 0.8, "path": [[0, 0, 1], [0, 0.1, 1.3]])",
    R"({"tool": "rotate", "center": [0, 0, 0], "axis": [0, 1, 0], "inner": 0.5, "outer": 2, "angle_deg": 40)",
    R"({"tool": "stretch", "center": [0, 0, 0], "axis": [1, 0, 0], "inner": 0.2, "outer": 1.5, "factor": 1.4)"};

Session session_of(const std::vector<std::string>& lines) {
  std::string text = "{\"knead\": 1}\n";
  for (const std::string& line : lines) text += line + "\n";
  return parse_session(text, "s.knead");
}

Session timed_session(const std::vector<std::string>& durations) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < durations.size(); ++i) {
    lines.push_back(std::string(kStrokes[i]) + (durations[i].empty() ? "}" : ", \"duration\": " + durations[i] + "}"));
  }
  return session_of(lines);
}

using Positions = std::vector<Vec3d>;

std::vector<Positions> frames_of(const Mesh& mesh, const Session& session, ReplayOptions options) {
  std::vector<Positions> frames;
  options.frames.deliver = [&](const ReplayFrame& frame) { frames.push_back(frame.shape.positions()); };
  replay(mesh, session, options);
  EXPECT_EQ(static_cast<int>(frames.size()), frame_count(options.frames));
  return frames;
}

Positions until(const Mesh& mesh, const Session& session, double strokes) {
  ReplayOptions options;
  options.part.until = strokes;
  return replay(mesh, session, options).shape.positions();
}

Mesh ball() { return make_shape(ShapeKind::sphere, 642); }

void expect_moments(const Session& session, const FrameOptions& frames, const std::vector<double>& moments) {
  const Mesh mesh = ball();
  ReplayOptions options;
  options.frames = frames;
  const std::vector<Positions> found = frames_of(mesh, session, options);
  ASSERT_EQ(found.size(), moments.size());
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_EQ(found[k], until(mesh, session, moments[k])) << k;
}

TEST(Frames, AStrokeTakesItsDuration) {
  expect_moments(timed_session({"2", "1", "0.5"}), {8}, {0, 0.25, 0.5, 0.75, 1, 1.5, 2, 3});
  expect_moments(timed_session({"", "3"}), {5}, {0, 1, 1 + 1.0 / 3, 1 + 2.0 / 3, 2});
}

TEST(Frames, BackwardsTheyTakeTheSameTime) {
  const Mesh mesh = ball();
  const Session session = timed_session({"2", "1", "0.5"});
  ReplayOptions options;
  options.frames.count = 8;
  options.motion.relative_tolerance = 1e-9;
  options.motion.precision = Precision::float64;
  std::vector<Positions> there = frames_of(mesh, session, options);
  Mesh deformed = mesh;
  deformed.positions = there.back();
  options.part.direction = Direction::backwards;
  const std::vector<Positions> back = frames_of(deformed, session, options);
  for (std::size_t k = 0; k < back.size(); ++k) {
    const Positions& same = there[there.size() - 1 - k];
    for (std::size_t i = 0; i < same.size(); ++i) ASSERT_LT(norm(back[k][i] - same[i]), 1e-6) << k;
  }
}

TEST(Frames, UntilEndsTheTimeWithinAStroke) {
  const Mesh mesh = ball();
  const Session session = timed_session({"1", "4"});
  ReplayOptions options;
  options.frames.count = 4;
  options.part.until = 1.5;  // 3 units of time
  const std::vector<Positions> frames = frames_of(mesh, session, options);
  EXPECT_EQ(frames[1], until(mesh, session, 1));
  EXPECT_EQ(frames[2], until(mesh, session, 1.25));
  EXPECT_EQ(frames[3], until(mesh, session, 1.5));
}

TEST(Frames, SmoothTimeIsSlowAtItsEnds) {
  expect_moments(timed_session({"", ""}), {5, Ease::smooth}, {0, 2 * 0.15625, 1, 2 * 0.84375, 2});
}

TEST(Frames, WithoutStrokesAllAreTheShapeAsItIs) {
  for (const Ease ease : {Ease::linear, Ease::smooth}) expect_moments(timed_session({}), {3, ease, 1}, {0, 0, 0, 0, 0});
}

TEST(Frames, TheStartAndTheEndAreHeld) {
  expect_moments(timed_session({"", ""}), {3, Ease::linear, 2}, {0, 0, 0, 1, 2, 2, 2});
  expect_moments(timed_session({""}), {1, Ease::smooth, 1}, {1, 1, 1});
  EXPECT_EQ(frame_count({0, Ease::linear, 5}), 0);
  ReplayOptions options;
  for (const int hold : {-1, kMaxFrames + 1, std::numeric_limits<int>::max()}) {
    options.frames = {3, Ease::linear, hold};
    EXPECT_THROW(replay(ball(), timed_session({""}), options), InvalidInput) << hold;
  }
}

TEST(Frames, ARemeshedResultIsTakenBackWithItsFaces) {
  const Mesh mesh = ball();
  const Session session = timed_session({"", "2"});
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.frames.count = 6;
  options.frames.hold = 1;
  options.frames.same_faces = true;
  const std::vector<Positions> frames = frames_of(mesh, session, options);
  options.frames = {};
  const DeformedShape result = replay(mesh, session, options).shape;
  EXPECT_GT(result.positions().size(), mesh.vertex_count());
  EXPECT_EQ(frames.back(), result.positions());
  EXPECT_EQ(frames[6], result.positions());
  EXPECT_EQ(frames[0], frames[1]);
  Mesh shape = result.to_mesh();
  std::vector<double> volumes;
  for (const Positions& frame : frames) {
    shape.positions = frame;
    volumes.push_back(measure(shape).volume);
    EXPECT_NEAR(volumes.back(), volumes.front(), 2e-4 * volumes.front());
  }
  // On the ball, whose triangles lie up to 0.012 within the sphere; the compensation of volume moves vertices by less
  // than a fifth of that.
  for (const Vec3d& p : frames[0]) EXPECT_NEAR(norm(p), 1 - 0.005, 0.0075);
}

TEST(Frames, UntilCutsARemeshedSessionOnlyWhereItsStrokesAreThoseApplied) {
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.frames.count = 3;
  options.frames.same_faces = true;
  options.part.until = 1.5;
  const std::vector<Positions> frames = frames_of(ball(), timed_session({"", ""}), options);
  ReplayOptions end = options;
  end.frames = {};
  EXPECT_EQ(frames.back(), replay(ball(), timed_session({"", ""}), end).shape.positions());
  Session with_nothing = timed_session({"", ""});
  with_nothing.strokes.front().strength = 0;
  EXPECT_THROW(replay(ball(), with_nothing, options), InvalidInput);
}

TEST(Frames, ARelaxHasNoInverse) {
  const Session session =
      session_of({std::string(kStrokes[0]) + "}", R"({"relax": {"points": [[0, 0, 1.2]], "radius": 0.3}})"});
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.frames.count = 3;
  options.frames.same_faces = true;
  try {
    replay(ball(), session, options);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("s.knead:3: a relax is no flow")) << error.what();
  }
}

}  // namespace
}  // namespace knead::frames_test
