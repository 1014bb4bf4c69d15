// The keys that every stroke may have: name, off, strength and duration.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "knead/certify.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "support/scratch.h"

namespace knead::stroke_keys_test {
namespace {

// A stroke of every tool on the unit ball, those that read the surface included, as lines of a session without their
// last brace, and how many segments each has at most.
struct ToolLine {
  const char* name;
  const char* line;

  friend std::ostream& operator<<(std::ostream& out, const ToolLine& tool) { return out << tool.name; }
};

// The first of these have no falloff from 3 to 7.
constexpr int kToolsWithoutFalloff = 6;
constexpr ToolLine kTools[] = {
    {"pose",
     R"({"tool": "pose", "detail": 0.1, "parts": [{"vertices": [[0, 5]], "hold": true}, {"pin_point": [0, 0, 1], "to": [0.2, 0, 1.2]}])"},
    {"print", R"({"tool": "print", "file": "ball.ply", "point": [0, 0, 1], "height": 0.6, "depth": 0.05)"},
    {"wide", R"({"tool": "implicit", "falloff": "wide", "bump": 0.2, "path": [[0,0,1], [0,0.2,1.1], [0.2,0.3,1.3]])"},
    {"wide_core",
     R"({"tool": "implicit", "falloff": "wide", "bump": 0.3, "outer": 0.8, "core": 0.4, "path": [[0,0,1], [0,0.2,1.1], [0,0.4,1.1]])"},
    {"wide_paint",
     R"({"tool": "paint", "falloff": "wide", "bump": 0.2, "depth": -0.1, "path": [[0.5,0,1], [0,0.2,1.2]])"},
    {"tapered",
     R"({"tool": "implicit", "inner": 0.2, "outer": 0.7, "taper": 0.6, "path": [[0,0,1], [0,0.2,1.1], [0.2,0.3,1.3]])"},
    {"implicit", R"({"tool": "implicit", "inner": 0.2, "outer": 0.7, "path": [[0,0,1], [0,0.2,1.1], [0.2,0.3,1.3]])"},
    {"paint",
     R"({"tool": "paint", "outer": 0.4, "depth": 0.05, "samples": [{"point": [0,0,1], "normal": [0,0,1]}, {"point": [0,0.2,0.96], "normal": [0,0.2,1]}])"},
    {"paint_path", R"({"tool": "paint", "outer": 0.4, "depth": -0.1, "path": [[0.5,0,1], [0,0.2,1.2]])"},
    {"points",
     R"({"tool": "points", "points": [[0.3,0,1], [-0.3,0,1]], "outer": 0.4, "displacements": [[0,0.1,0], [0,0.1,0.1]])"},
    {"handles", R"({"tool": "handles", "full": [[0,0,1]], "zero": [[0,0,-1]], "motion": {"translate": [0,0.2,0]})"},
    {"handles_by_vertices",
     R"({"tool": "handles", "full_vertices": [0,1,2], "zero_vertices": [200,201], "motion": {"rotate": [0,1,0], "center": [0,0,0], "angle_deg": 10})"},
    {"stamp", R"({"tool": "stamp", "mesh": "ball.ply", "outer": 0.5, "step": 0.05, "path": [[1.4,0,0], [1.2,0,0]])"},
    {"rotate", R"({"tool": "rotate", "center": [0,0,1], "axis": [0,0,1], "angle_deg": 30, "inner": 0.1, "outer": 0.6)"},
    {"stretch", R"({"tool": "stretch", "center": [0,0,1], "axis": [0,0,1], "factor": 1.5, "inner": 0.1, "outer": 0.6)"},
    {"twist", R"({"tool": "twist", "center": [0,0,0], "axis": [0,0,1], "rate_deg": 40, "inner": -0.5, "outer": 0.5)"},
    {"twist_auto",
     R"({"tool": "twist", "center": [0,0,0.5], "axis": [0,0,-1], "rate_deg": 20, "inner": -0.3, "outer": 0.2, "radius": "auto")"},
    {"bend",
     R"({"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,0,-1], "width": 1, "angle_deg": 40)"}};

std::string name_of(const testing::TestParamInfo<ToolLine>& test) { return test.param.name; }

class StrokeKeys : public testing::TestWithParam<ToolLine> {
 protected:
  StrokeKeys() {
    Mesh stamp = make_shape(ShapeKind::sphere, 400);
    for (Vec3d& p : stamp.positions) p = p * 0.3;
    write_mesh(folder_ / "ball.ply", stamp);
  }

  // The tool's line with more keys, e.g. `, "strength": 0.5`.
  std::string line(const std::string& keys = "") const { return GetParam().line + keys + "}\n"; }

  Session session(const std::string& lines) const {
    return parse_session("{\"knead\": 1}\n" + lines, (folder_ / "s.knead").string());
  }

  static std::vector<Vec3d> result_of(const Session& session, const ReplayOptions& options = {}) {
    const ReplayResult result = replay(make_shape(ShapeKind::sphere, 1500), session, options);
    EXPECT_EQ(result.status, AdvectStatus::done);
    return result.shape.positions();
  }

  std::vector<Vec3d> result_of(const std::string& lines, const ReplayOptions& options = {}) const {
    return result_of(session(lines), options);
  }

  static std::vector<Vec3d> start() { return make_shape(ShapeKind::sphere, 1500).positions; }

  static double distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, norm(a[i] - b[i]));
    return most;
  }

  static ReplayOptions exact() {
    ReplayOptions options;
    options.motion.precision = Precision::float64;
    options.motion.relative_tolerance = 1e-9;
    return options;
  }

  static constexpr const char* kPull =
      R"({"tool": "implicit", "inner": 0.2, "outer": 0.7, "path": [[0, 1, 0], [0, 1.2, 0]]})"
      "\n";

  test::Scratch scratch_{"stroke_keys"};
  const std::filesystem::path& folder_ = scratch_.path();
};

TEST_P(StrokeKeys, StrengthOneIsNoStrength) {
  EXPECT_TRUE(result_of(line(R"(, "strength": 1)")) == result_of(line()));
  EXPECT_EQ(serialize_session(session(line(R"(, "strength": 1, "off": false, "name": "")"))),
            serialize_session(session(line())));
}

TEST_P(StrokeKeys, StrengthZeroLeavesEveryBit) {
  EXPECT_TRUE(result_of(line(R"(, "strength": 0)")) == start());
  EXPECT_FALSE(result_of(line()) == start());
}

TEST_P(StrokeKeys, PartOfAStrengthIsUntilThatPart) {
  for (const double part : {0.25, 0.5, 0.8}) {
    ReplayOptions until;
    until.part.until = part;
    const std::string key = ", \"strength\": " + std::to_string(part);
    EXPECT_TRUE(result_of(line(key)) == result_of(line(), until)) << part;
    EXPECT_TRUE(result_of(line(", \"strength\": 0.5"), until) == result_of(line(),
                                                                           [&] {
                                                                             ReplayOptions half = until;
                                                                             half.part.until = 0.5 * part;
                                                                             return half;
                                                                           }()))
        << "until cuts what the strength leaves";
  }
}

// Beyond 1 the stroke first does what it does with strength 1, and goes on without a jump.
TEST_P(StrokeKeys, BeyondOneTheStrokeGoesOn) {
  const std::vector<Vec3d> at_one = result_of(line(), exact());
  const double moved = distance(at_one, start());
  const double little = distance(result_of(line(", \"strength\": 1.000001"), exact()), at_one);
  EXPECT_LT(little, 1e-4 * moved);
  const double more = distance(result_of(line(", \"strength\": 1.5"), exact()), at_one);
  if (std::string_view(GetParam().name) == "tapered") {
    EXPECT_EQ(more, 0) << "it ends at its tip";
    return;
  }
  EXPECT_GT(more, 0.1 * moved);
  EXPECT_LT(more, 1.5 * moved);
}

TEST_P(StrokeKeys, TheInverseUndoesEveryStrength) {
  for (const char* strength : {"0", "0.3", "0.5", "1", "1.4"}) {
    const std::string lines = kPull + line(std::string(", \"strength\": ") + strength);
    Session resolved = session(lines);
    Mesh mesh = make_shape(ShapeKind::sphere, 1500);
    resolved.strokes = replay(mesh, resolved, exact()).resolved;
    mesh.positions = result_of(resolved, exact());
    ReplayOptions back = exact();
    back.part.direction = Direction::backwards;
    const ReplayResult result = replay(mesh, resolved, back);
    // Every segment may err by the tolerance there and back, magnified by its stretch: a stamp has some 20.
    EXPECT_LT(distance(result.shape.positions(), start()), 1e-6) << strength;
  }
}

TEST_P(StrokeKeys, AnOffStrokeIsAbsent) {
  const std::string off = kPull + line(R"(, "off": true)") + kPull;
  const std::string absent = std::string(kPull) + kPull;
  for (const std::optional<double> until : {std::optional<double>{}, std::optional<double>{1.5}}) {
    ReplayOptions options;
    options.part.until = until;
    EXPECT_TRUE(result_of(off, options) == result_of(absent, options));
  }
  ReplayOptions back;
  back.part.direction = Direction::backwards;
  EXPECT_TRUE(result_of(off, back) == result_of(absent, back));
  const ReplayResult result = replay(make_shape(ShapeKind::sphere, 1500), session(off));
  EXPECT_EQ(result.strokes, 2u);
  EXPECT_EQ(result.resolved.size(), 2u);
  EXPECT_EQ(without_off(session(off)).strokes.size(), 2u);
}

TEST_P(StrokeKeys, AResolvedSessionGivesTheSameBits) {
  for (const char* strength : {"0", "0.35", "0.5", "1", "1.3"}) {
    const Session given = session(kPull + line(std::string(R"(, "name": "a", "strength": )") + strength) + kPull);
    Session resolved;
    const ReplayResult first = replay(make_shape(ShapeKind::sphere, 1500), given);
    resolved.strokes = first.resolved;
    resolved = parse_session(serialize_session(resolved), "resolved.knead");
    const ReplayResult again = replay(make_shape(ShapeKind::sphere, 1500), resolved);
    EXPECT_TRUE(again.shape.positions() == first.shape.positions()) << strength;
    EXPECT_EQ(again.segments, first.segments) << strength;
    for (const SessionStroke& stroke : resolved.strokes) {
      EXPECT_FALSE(stroke.off);
      EXPECT_FALSE(reads_surface(stroke.stroke));
    }
  }
}

TEST_P(StrokeKeys, FramesFollowTheStrength) {
  for (const char* strength : {"0", "0.6", "1.2"}) {
    const Session given = session(kPull + line(std::string(", \"strength\": ") + strength) + kPull);
    std::vector<std::vector<Vec3d>> frames;
    ReplayOptions options;
    options.frames.count = 7;
    options.frames.deliver = [&](const ReplayFrame& frame) { frames.push_back(frame.shape.positions()); };
    Progress progress;
    options.progress = &progress;
    const std::uint64_t work = Replay(borrow(make_shape(ShapeKind::sphere, 1500)), given, options).work();
    const std::vector<Vec3d> result = result_of(given, options);
    EXPECT_EQ(progress.done, work);
    ASSERT_EQ(frames.size(), 7u);
    EXPECT_TRUE(frames.back() == result);
    ReplayOptions until;
    for (int k = 0; k < 6; ++k) {
      until.part.until = 3.0 * k / 6;
      EXPECT_TRUE(frames[k] == result_of(given, until)) << strength << ", frame " << k;
    }
  }
}

TEST_P(StrokeKeys, ADurationIsKeptAndMovesNothing) {
  const Session given = session(line(R"(, "duration": 2.5)"));
  EXPECT_EQ(given.strokes.front().duration, 2.5);
  EXPECT_TRUE(parse_session(serialize_session(given), given.name) == given);
  EXPECT_TRUE(result_of(given) == result_of(line()));
  EXPECT_EQ(serialize_session(session(line(R"(, "duration": 1)"))), serialize_session(session(line())));
  for (const char* wrong : {"0", "-1", "\"long\"", "null"}) {
    EXPECT_THROW(session(line(std::string(R"(, "duration": )") + wrong)), InvalidInput) << wrong;
  }
}

// Several strokes that one becomes take its time together.
TEST_P(StrokeKeys, AResolvedSessionMovesAtTheSameTimes) {
  const Session given = session(kPull + line(R"(, "duration": 3)"));
  Session resolved;
  resolved.strokes = replay(make_shape(ShapeKind::sphere, 1500), given).resolved;
  double duration = 0;
  for (const SessionStroke& stroke : resolved.strokes) duration += stroke.duration;
  EXPECT_NEAR(duration, 4, 1e-12);
  const auto frames_of = [](const Session& session) {
    std::vector<std::vector<Vec3d>> frames;
    ReplayOptions options;
    options.frames.count = 7;
    options.frames.deliver = [&](const ReplayFrame& frame) { frames.push_back(frame.shape.positions()); };
    replay(make_shape(ShapeKind::sphere, 1500), session, options);
    return frames;
  };
  const auto before = frames_of(given);
  const auto after = frames_of(resolved);
  for (std::size_t k = 0; k < before.size(); ++k) EXPECT_LT(distance(before[k], after[k]), 1e-6) << k;
}

// The workbench of an editor, which applies strokes one by one, has the bits of a replay.
TEST_P(StrokeKeys, AWorkbenchHasTheBitsOfAReplay) {
  for (const char* keys : {R"(, "off": true)", R"(, "strength": 0)", R"(, "strength": 0.4)", R"(, "strength": 1.5)"}) {
    const Session given = session(kPull + line(keys));
    Workbench bench(make_shape(ShapeKind::sphere, 1500), folder_);
    EXPECT_TRUE(bench.append(given.strokes).is_done()) << keys;
    EXPECT_TRUE(bench.state().positions.copy() == result_of(given)) << keys;
  }
}

// Tools that blend.
class StrokeFalloff : public StrokeKeys {};

TEST_P(StrokeFalloff, FalloffFourIsNoFalloff) {
  EXPECT_TRUE(result_of(line(R"(, "falloff": 4)")) == result_of(line()));
  EXPECT_EQ(serialize_session(session(line(R"(, "falloff": 4)"))), serialize_session(session(line())));
}

TEST_P(StrokeFalloff, EveryFalloffMovesInItsOwnWayAndComesBack) {
  std::vector<std::vector<Vec3d>> results{result_of(line(), exact())};
  for (const char* falloff : {"3", "5", "6", "7"}) {
    const std::string lines = line(std::string(R"(, "falloff": )") + falloff);
    Session resolved = session(lines);
    EXPECT_EQ(serialize_session(parse_session(serialize_session(resolved), "s.knead")), serialize_session(resolved));
    Mesh mesh = make_shape(ShapeKind::sphere, 1500);
    resolved.strokes = replay(mesh, resolved, exact()).resolved;
    for (const SessionStroke& stroke : resolved.strokes) EXPECT_EQ(falloff_of(stroke.stroke), std::stoi(falloff));
    mesh.positions = result_of(lines, exact());
    for (const std::vector<Vec3d>& other : results) EXPECT_GT(distance(mesh.positions, other), 1e-4) << falloff;
    results.push_back(mesh.positions);
    ReplayOptions back = exact();
    back.part.direction = Direction::backwards;
    EXPECT_LT(distance(replay(mesh, resolved, back).shape.positions(), start()), 1e-6) << falloff;
  }
}

TEST_P(StrokeFalloff, AFalloffResolvedOrAtTheWorkbenchHasTheSameBits) {
  for (const char* keys :
       {R"(, "falloff": 3)", R"(, "falloff": 7, "strength": 0.6)", R"(, "falloff": 6, "strength": 1.2)"}) {
    const Session given = session(kPull + line(keys));
    Session resolved;
    const ReplayResult first = replay(make_shape(ShapeKind::sphere, 1500), given);
    resolved.strokes = first.resolved;
    resolved = parse_session(serialize_session(resolved), "resolved.knead");
    EXPECT_TRUE(result_of(resolved) == first.shape.positions()) << keys;
    Workbench bench(make_shape(ShapeKind::sphere, 1500), folder_);
    EXPECT_TRUE(bench.append(given.strokes).is_done()) << keys;
    EXPECT_TRUE(bench.state().positions.copy() == first.shape.positions()) << keys;
  }
}

// The mesh is finer than the others here: what is left is how triangles sample the smooth flow.
TEST_P(StrokeFalloff, EveryFalloffKeepsTheVolume) {
  const Mesh ball = make_shape(ShapeKind::sphere, 40'962);
  for (const char* falloff : {"3", "4", "5", "6", "7"}) {
    const Session given = session(line(std::string(R"(, "falloff": )") + falloff));
    const Mesh moved = replay(ball, given).shape.to_mesh();
    EXPECT_NEAR(measure(moved).volume / measure(ball).volume, 1, 5e-4) << falloff;
  }
}

INSTANTIATE_TEST_SUITE_P(Tools, StrokeKeys, testing::ValuesIn(kTools), name_of);
INSTANTIATE_TEST_SUITE_P(Tools, StrokeFalloff,
                         testing::ValuesIn(std::begin(kTools) + kToolsWithoutFalloff, std::end(kTools)), name_of);

std::string error_of(const std::string& keys) {
  const std::string rotate =
      R"({"tool": "rotate", "center": [0,0,0], "axis": [0,0,1], "angle_deg": 300000, "inner": 0, "outer": 1, )";
  try {
    parse_session("{\"knead\": 1}\n" + rotate + keys + "}\n", "s.knead");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(StrokeKeyErrors, NameTheKeyAndWhatWasExpected) {
  EXPECT_EQ(error_of(R"("strength": -0.1)"), "s.knead:2: \"strength\" must be a number from 0 to 1.5, got -0.1");
  EXPECT_EQ(error_of(R"("strength": 1.6)"), "s.knead:2: \"strength\" must be a number from 0 to 1.5, got 1.6");
  EXPECT_EQ(error_of(R"("strength": "half")"), "s.knead:2: \"strength\" must be a number, got \"half\"");
  EXPECT_EQ(error_of(R"("off": 1)"), "s.knead:2: \"off\" must be true or false, got 1");
  EXPECT_EQ(error_of(R"("name": 7)"), "s.knead:2: \"name\" must be text in double quotes, got 7");
  EXPECT_NE(error_of(R"("strength": 1.5)").find("\"strength\" asks for too much: \"angle_deg\" must be"),
            std::string::npos)
      << error_of(R"("strength": 1.5)");
  const auto of_ball = [](const std::string& keys) {
    try {
      parse_session("{\"knead\": 1}\n{\"tool\": \"implicit\", \"path\": [[0,0,0], [1,0,0]], " + keys + "}\n",
                    "s.knead");
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string wide = R"("falloff": "wide")";
  EXPECT_EQ(of_ball(wide + R"(, "bump": 0.2, "core": 0.8)"), "");
  EXPECT_NE(of_ball(wide).find("\"bump\" is missing"), std::string::npos) << of_ball(wide);
  EXPECT_EQ(of_ball(wide + R"(, "bump": 0.2, "inner": 0.1)"), "s.knead:2: \"inner\" needs a \"falloff\" from 3 to 7");
  EXPECT_EQ(of_ball(R"("inner": 0.1, "outer": 0.2, "bump": 0.1)"), "s.knead:2: \"bump\" needs \"falloff\": \"wide\"");
  EXPECT_EQ(of_ball(wide + R"(, "bump": 0.2, "outer": 0.2)"),
            "s.knead:2: \"outer\" must be a number greater than \"bump\" (0.2), got 0.2");
  EXPECT_EQ(of_ball(wide + R"(, "bump": 0.2, "core": 0.9)"),
            "s.knead:2: \"core\" must be a number from 0 to 0.8, got 0.9");
  EXPECT_EQ(of_ball(wide + R"(, "bump": 0.2, "taper": 1.1)"),
            "s.knead:2: \"taper\" must be a number from 0 to 1, got 1.1");
  EXPECT_EQ(of_ball(wide + R"(, "bump": 0.2, "region": "capsule", "half_axis": [0,0,1])"),
            "s.knead:2: \"falloff\": \"wide\" needs \"region\": \"ball\"");
  for (const char* const falloff : {"8", "\"flat\""}) {
    EXPECT_EQ(of_ball(std::string(R"("bump": 0.2, "falloff": )") + falloff),
              "s.knead:2: \"falloff\" must be a whole number from 3 to 7, or \"wide\", got " + std::string(falloff));
  }
  EXPECT_EQ(error_of(R"("falloff": "wide")"), "s.knead:2: \"falloff\" must be a whole number, got \"wide\"");
  EXPECT_EQ(error_of(R"("falloff": 2)"), "s.knead:2: \"falloff\" must be a whole number from 3 to 7, got 2");
  EXPECT_EQ(error_of(R"("falloff": 8)"), "s.knead:2: \"falloff\" must be a whole number from 3 to 7, got 8");
  EXPECT_EQ(error_of(R"("falloff": 4.5)"),
            "s.knead:2: \"falloff\" must be a whole number of at most 9 digits, got 4.5");
  EXPECT_EQ(error_of(R"("falloff": "x")"), "s.knead:2: \"falloff\" must be a whole number, got \"x\"");
  EXPECT_EQ(error_of(R"("name": "A horn", "off": true, "strength": 0.5)"), "");
}

TEST(StrokeKeyLines, ComeBackAsTheyWere) {
  SessionStroke stroke{RotateStroke{{1, 2, 3}, {0, 0, 1}, 30, 0, 1}};
  stroke.name = "left \"ear\"\n\\ \xC3\xA9";
  stroke.off = true;
  stroke.strength = 0.1 + 0.2;
  Session session;
  session.strokes = {stroke};
  Session again = parse_session(serialize_session(session), "s.knead");
  ASSERT_EQ(again.strokes.size(), 1u);
  again.strokes[0].line = 0;
  EXPECT_EQ(again.strokes[0], stroke);
  EXPECT_EQ(stroke_line(SessionStroke{stroke.stroke}), stroke_line(stroke.stroke)) << "defaults are left out";
}

TEST(StrokeKeyLines, UndoCountsAStrokeThatIsOff) {
  const std::string rotate =
      R"({"tool": "rotate", "center": [0,0,0], "axis": [0,0,1], "angle_deg": 30, "inner": 0, "outer": 1)";
  const std::string text = "{\"knead\": 1}\n" + rotate + "}\n" + rotate + ", \"off\": true}\n{\"undo\": 1}\n";
  const Session session = parse_session(text, "s.knead");
  ASSERT_EQ(session.strokes.size(), 1u);
  EXPECT_FALSE(session.strokes[0].off);
}

// A relax has no flow, but the same keys.
TEST(StrokeKeyRelax, FollowsTheStrength) {
  const Mesh ball = make_shape(ShapeKind::sphere, 1500);
  const auto relaxed = [&](const std::string& keys, std::optional<double> until = {}) {
    const std::string pull = R"({"tool": "implicit", "inner": 0.1, "outer": 0.5, "path": [[0,0,1], [0,0,1.3]]})";
    const std::string relax = R"({"relax": {"points": [[0,0,1.2], [0.2,0,1]], "radius": 0.5, "amount": 0.4)";
    ReplayOptions options;
    if (until) options.part.until = until;
    return replay(ball, parse_session("{\"knead\": 1}\n" + pull + "\n" + relax + keys + "}}\n", "s"), options)
        .shape.positions();
  };
  EXPECT_TRUE(relaxed(", \"strength\": 0.5") == relaxed("", 1.5));
  EXPECT_TRUE(relaxed(", \"strength\": 0") == relaxed("", 1.0));
  EXPECT_TRUE(relaxed(", \"off\": true") == relaxed("", 1.0));
  EXPECT_TRUE(relaxed(", \"strength\": 1, \"name\": \"smooth\"") == relaxed(""));
  EXPECT_FALSE(relaxed(", \"strength\": 1.5") == relaxed(""));
}

// A stroke is remeshed as it would be where --until cuts it; with strength 0 the mesh stays.
TEST(StrokeKeyRemesh, FollowsTheStrength) {
  const Mesh ball = make_shape(ShapeKind::sphere, 1500);
  Session session;
  session.strokes = {{ImplicitStroke{{{0, 0, 1}, {0, 0.2, 1.5}, {0, 0.2, 2}}, 0.2, 0.7}, 2, RemeshSettings{}}};
  ReplayOptions until;
  until.part.until = 0.6;
  const Mesh expected = replay(ball, session, until).shape.to_mesh();
  session.strokes[0].strength = 0.6;
  const Mesh cut = replay(ball, session).shape.to_mesh();
  EXPECT_TRUE(cut.positions == expected.positions);
  EXPECT_TRUE(cut.corner_vertex == expected.corner_vertex);
  EXPECT_GT(cut.positions.size(), ball.positions.size());
  session.strokes[0].strength = 0;
  EXPECT_FALSE(replay(ball, session).shape.is_remeshed());
}

// The stroke with an angle or a path so many times as long.
Stroke scaled(Stroke stroke, double factor) {
  if (auto* rotate = std::get_if<RotateStroke>(&stroke)) rotate->angle_deg *= factor;
  if (auto* implicit = std::get_if<ImplicitStroke>(&stroke)) {
    implicit->path[1] = implicit->path[0] + (implicit->path[1] - implicit->path[0]) * factor;
  }
  return stroke;
}

Certificate certificate_of(const Mesh& mesh, const Session& session) {
  ReplayOptions options;
  CertificateBuilder builder(mesh, options);
  options.on_stroke = [&](const AppliedStroke& stroke) { builder.add(stroke); };
  const ReplayResult result = replay(mesh, session, options);
  EXPECT_EQ(result.strokes, session.strokes.size());
  return builder.finish(result, true);
}

TEST(StrokeKeyCertificate, HoldsForEveryStrength) {
  const Mesh ball = make_shape(ShapeKind::sphere, 10242);
  for (const double strength : {0.0, 0.5, 1.5}) {
    Session session;
    session.strokes = {{RotateStroke{{0, 1, 0}, {0, 1, 0}, 60, 0.2, 0.8}, 2},
                       {ImplicitStroke{{{1, 0, 0}, {1.2, 0, 0}}, 0.2, 0.7}, 3}};
    Session same = session;  // the same motion without the key, up to rounding
    for (std::size_t i = 0; i < 2; ++i) {
      session.strokes[i].strength = strength;
      if (strength > 0) same.strokes[i].stroke = scaled(same.strokes[i].stroke, strength);
    }
    if (strength == 0) same.strokes.clear();
    const Certificate certificate = certificate_of(ball, session);
    const Certificate expected = certificate_of(ball, same);
    EXPECT_EQ(certificate.crossings_after, 0u) << strength;
    EXPECT_EQ(certificate.motion_outside, 0) << strength;
    EXPECT_NEAR(certificate.volume_error.value(), expected.volume_error.value(), 1e-6) << strength;
    EXPECT_NEAR(certificate.carried_back_max, expected.carried_back_max, 1e-5) << strength;
  }
}

}  // namespace
}  // namespace knead::stroke_keys_test
