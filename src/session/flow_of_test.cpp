// Sessions as flows, and single strokes from text.
#include <gtest/gtest.h>

#include <cmath>

#include "knead/certify.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"

namespace knead::flow_of_test {
namespace {

const Mesh& sphere() {
  static const Mesh mesh = make_shape(ShapeKind::sphere, 3000);
  return mesh;
}

// Strengths below and above 1, a stroke that is off, a mask, several segments a stroke, pins.
Session varied() {
  return parse_session(
      R"({"knead": 1}
{"tool": "implicit", "inner": 0.1, "outer": 0.6, "path": [[0, 1, 0], [0.1, 1.3, 0], [0.3, 1.2, 0]], "strength": 0.7}
{"tool": "rotate", "center": [0, 0, 0], "axis": [0, 1, 0], "angle_deg": 30, "inner": 0.5, "outer": 1.5, "off": true}
{"mask": {"points": [[1, 0, 0]], "width": 0.3}}
{"tool": "bend", "center": [0, 0, 0], "axis": [0, 0, 1], "normal": [0, 1, 0], "width": 1.5, "angle_deg": 40, "strength": 1.2}
{"tool": "pins", "points": [[0, -1, 0], [1, 0, 0]], "to": [[0, -1.2, 0], [1, 0, 0]], "radius": 1}
{"tool": "grid", "origin": [0, 1, 0], "spacing": 0.5, "counts": [1, 1, 1], "coefficients": "AAAAAAAAAAAAAAAAAAAAAAAAAAAAANA/", "strength": 0.6}
)",
      "varied");
}

std::vector<Vec3d> moved_by(const Flow& flow, const std::vector<Vec3d>& points) {
  std::vector<Vec3d> moved = points;
  EXPECT_EQ(advect(flow, moved, advect_options({}, reference_length(points))).status, AdvectStatus::done);
  return moved;
}

TEST(FlowOfSession, MovesPointsAsAReplayToTheBit) {
  const Session session = varied();
  EXPECT_FALSE(needs_faces(session));
  for (const std::optional<double> until : {std::optional<double>(), std::optional(0.0), std::optional(0.6),
                                            std::optional(2.4), std::optional(4.0), std::optional(4.7)}) {
    for (const Direction direction : {Direction::forwards, Direction::backwards}) {
      ReplayOptions options;
      options.part = {direction, until};
      const std::vector<Vec3d> expected = replay(sphere(), session, options).shape.positions();
      EXPECT_EQ(moved_by(flow_of(session, options.part), sphere().positions), expected) << until.value_or(-1);
    }
  }
}

TEST(FlowOfSession, RefusesWhatIsNoFlowWithItsLine) {
  const auto refusal = [](const std::string& line) -> std::string {
    const Session session = parse_session("{\"knead\": 1}\n" + line + "\n", "s.knead");
    EXPECT_TRUE(needs_faces(session));
    try {
      flow_of(session);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_TRUE(refusal(R"({"tool": "paint", "outer": 0.3, "depth": 0.1, "path": [[0, 1, 0]]})")
                  .starts_with("s.knead:2: this stroke reads the surface"));
  EXPECT_TRUE(refusal(R"({"relax": {"points": [[0, 1, 0]], "radius": 0.2}})").starts_with("s.knead:2: a relax"));
  EXPECT_TRUE(refusal(R"({"mask": {"vertices": [3], "width": 0.2}})").starts_with("s.knead:2: this stroke reads"));
}

TEST(FlowOfSession, LimitCylindersAndRemeshEventsNeedFaces) {
  EXPECT_TRUE(needs_faces(parse_session(
      R"({"knead": 1}
{"tool": "bend", "center": [0, 0, 0], "axis": [0, 0, 1], "normal": [0, 1, 0], "width": 1, "angle_deg": 9, "radius": 2}
)",
      "barrel")));
  EXPECT_TRUE(needs_faces(parse_session(
      R"({"knead": 1}
{"remesh": {}}
{"tool": "implicit", "inner": 0.1, "outer": 0.6, "path": [[0, 1, 0], [0.1, 1.3, 0]]}
)",
      "remesh")));
}

TEST(ParseStroke, ReadsWhatALineHolds) {
  for (const SessionStroke& stroke : varied().strokes) {
    SessionStroke read = parse_stroke(stroke_line(stroke), "one");
    EXPECT_EQ(read.line, 0u);
    read.line = stroke.line;
    EXPECT_EQ(read, stroke);
  }
  EXPECT_THROW(parse_stroke(R"({"undo": 1})", "one"), InvalidInput);
  EXPECT_THROW(parse_stroke("[]", "one"), InvalidInput);
  EXPECT_THROW(parse_stroke(R"({"tool": "bend")", "one"), InvalidInput);
}

// A list of one point needs no semicolon, nor a list of one curve or number.
TEST(ParseStroke, ReadsListsOfOneFromWords) {
  const auto same = [](const char* words, const char* json) {
    EXPECT_EQ(parse_stroke(words, "one"), parse_stroke(json, "one")) << words;
  };
  const char* const one =
      R"({"tool": "points", "points": [[0, 0, 1]], "displacements": [[0, 0, 0.1]], "inner": 0.1, "outer": 0.4})";
  same("points points=0,0,1 displacements=0,0,0.1 inner=0.1 outer=0.4", one);
  same("points points=0,0,1; displacements=0,0,0.1; inner=0.1 outer=0.4", one);
  same("points points=[[0,0,1]] displacements=[[0,0,0.1]] inner=0.1 outer=0.4", one);
  same(
      "points curves=0,0,1;0,1,0 displacements=0,0,0.1 inner=0.1 outer=0.4",
      R"({"tool": "points", "curves": [[[0, 0, 1], [0, 1, 0]]], "displacements": [[0, 0, 0.1]], "inner": 0.1, "outer": 0.4})");
  same("inflate points=0,0,1 depth=0.1 radius=0.4",
       R"({"tool": "inflate", "points": [[0, 0, 1]], "depth": 0.1, "radius": 0.4})");
  same("paint path=0,0,1 outer=0.4 depth=0.1", R"({"tool": "paint", "path": [[0, 0, 1]], "outer": 0.4, "depth": 0.1})");
  same("rotate center=0,0,1 axis=0,0,1 angle_deg=9 inner=0.1 outer=0.4",
       R"({"tool": "rotate", "center": [0, 0, 1], "axis": [0, 0, 1], "angle_deg": 9, "inner": 0.1, "outer": 0.4})");
  EXPECT_THROW(parse_stroke("points points=[0,0,1] displacements=0,0,0.1 inner=0.1 outer=0.4", "one"), InvalidInput);
}

TEST(ParseStroke, ATwistHasAnAngleOrARate) {
  const std::string twist = "twist center=0,0,0 axis=0,0,1 inner=-0.5 outer=1 ";
  const SessionStroke by_angle = parse_stroke(twist + "angle_deg=-90", "one");
  EXPECT_EQ(flow_of(by_angle), flow_of(parse_stroke(twist + "rate_deg=60", "one")));
  EXPECT_EQ(parse_stroke(stroke_line(by_angle), "one"), by_angle);
  EXPECT_THROW(parse_stroke(twist + "angle_deg=-90 rate_deg=60", "one"), InvalidInput);
  EXPECT_THROW(parse_stroke(twist, "one"), InvalidInput);
}

TEST(StrokeValues, HoldTheDefaultsToo) {
  const SessionStroke stroke =
      parse_stroke(R"({"tool": "implicit", "inner": 0.1, "outer": 0.6, "path": [[0, 1, 0], [0, 1.3, 0]]})", "one");
  EXPECT_EQ(
      stroke_values(stroke),
      R"({"name": "", "off": false, "strength": 1, "duration": 1, "path": [[0, 1, 0], [0, 1.3, 0]], "inner": 0.1, "outer": 0.6, )"
      R"("region": "ball", "time": "swept", "taper": 0, "falloff": 4})");
}

// The diagonal takes the place of the shape's own: a part of a shape moves as the whole of it does.
TEST(Diagonal, IsWhatTheToleranceIsRelativeTo) {
  Mesh cap;
  for (const Vec3d& p : sphere().positions) {
    if (p.y > 0.8) cap.positions.push_back(p);
  }
  Session session = varied();
  session.strokes.resize(1);
  ReplayOptions options;
  options.motion.diagonal = reference_length(sphere().positions);
  const std::vector<Vec3d> whole = replay(sphere(), session, {}).shape.positions();
  std::vector<Vec3d> expected;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (sphere().positions[i].y > 0.8) expected.push_back(whole[i]);
  }
  EXPECT_EQ(replay(cap, session, options).shape.positions(), expected);
  EXPECT_NE(replay(cap, session, {}).shape.positions(), expected);
}

// The certificate of given positions is that of the replay if they are its result, and else says how far off they are.
TEST(CertifyPositions, AreJudgedAsTheyAre) {
  Session session = varied();
  session.strokes.resize(1);
  const std::vector<Vec3d> after = replay(sphere(), session, {}).shape.positions();
  const Certificate right = certify(sphere(), after, session);
  EXPECT_EQ(right.crossings_after, 0u);
  EXPECT_EQ(right.motion_outside, 0);
  EXPECT_LT(right.distance_max, 0.01);
  std::vector<Vec3d> wrong = after;
  wrong[7] = wrong[7] * 1.5;
  const Certificate found = certify(sphere(), wrong, session);
  EXPECT_GT(std::max(found.motion_outside, found.distance_max), 0.1);
  EXPECT_GT(std::abs(*found.volume_error), 2 * std::abs(*right.volume_error));
  EXPECT_THROW(certify(sphere(), std::span(after).subspan(1), session), InvalidInput);
  wrong[7].x = NAN;
  EXPECT_THROW(certify(sphere(), wrong, session), InvalidInput);
}

}  // namespace
}  // namespace knead::flow_of_test
