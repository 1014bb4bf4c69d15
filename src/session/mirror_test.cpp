// Strokes of a session with the key "mirror".
#include <gtest/gtest.h>

#include <algorithm>

#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "support/random_segments.h"

namespace knead::mirror_test {
namespace {

const std::string kHeader = "{\"knead\": 1}\n";
const std::string kRotate =
    R"({"tool": "rotate", "mirror": "x", "center": [0.4, 0, 0.8], "axis": [0.2, 0, 1], "angle_deg": 70, "inner": 0.2, "outer": 0.8})";
const std::string kPull =
    R"({"tool": "implicit", "mirror": "x", "path": [[0.3, 0.8, 0], [0.6, 1.2, 0.1], [0.5, 1.4, 0.3]], "inner": 0.15, "outer": 0.7})";
const std::string kPaint =
    R"({"tool": "paint", "mirror": "xz", "outer": 0.4, "depth": -0.1, "path": [[0.1, 0.9, 0.3], [0.4, 0.8, 0.4]]})";
const std::string kBend =
    R"({"tool": "bend", "mirror": "x", "center": [0.6, 0, 0], "axis": [0, 0, 1], "normal": [-1, 0, 0], "angle_deg": 40, "width": 0.4, "radius": 1.5})";
const std::string kPins =
    R"({"tool": "pins", "mirror": "x", "points": [[0.6, 0.8, 0], [0, 1, 0]], "to": [[0.8, 1, 0], [0.1, 1.2, 0]], "radius": "auto"})";

Mesh sphere() { return make_shape(ShapeKind::sphere, 2562); }

Session session_of(const std::vector<std::string>& lines) {
  std::string text = kHeader;
  for (const std::string& line : lines) text += line + "\n";
  return parse_session(text, "s.knead");
}

std::vector<Vec3d> replayed(const Mesh& mesh, const Session& session, ReplayOptions options = {}) {
  options.motion.precision = Precision::float64;
  return replay(mesh, session, options).shape.positions();
}

// The mesh whose vertices are mirrored in x = 0, with faces that still point outwards.
Mesh flipped(const Mesh& mesh) {
  Mesh result = mesh;
  for (Vec3d& p : result.positions) p.x = -p.x;
  for (std::size_t f = 0; f < result.face_count(); ++f) {
    const auto begin = result.corner_vertex.begin() + result.face_begin[f];
    std::reverse(begin, result.corner_vertex.begin() + result.face_begin[f + 1]);
  }
  return result;
}

TEST(MirrorKey, AToolThatOverlapsItsImageIsTold) {
  const auto pulled = [](double x) {
    Session session = session_of({});
    SessionStroke line;
    line.stroke = ImplicitStroke{{{x, 0.8, 0}, {x, 1, 0}}, 0.15, 0.4};
    line.mirror = coordinate_mirror("x");
    session.strokes = {line};
    return replay(sphere(), session);
  };
  const auto motion = [](const ReplayResult& result) {
    const Mesh before = sphere();
    double greatest = 0;
    for (std::size_t i = 0; i < before.vertex_count(); ++i) {
      greatest = std::max(greatest, norm(result.shape.positions()[i] - before.positions[i]));
    }
    return greatest;
  };
  const auto is_told = [](const ReplayResult& result) {
    return std::any_of(result.warnings.begin(), result.warnings.end(), [](const std::string& warning) {
      return warning.find("moves 50% as far") != std::string::npos;
    });
  };
  EXPECT_FALSE(is_told(pulled(0)));
  EXPECT_FALSE(is_told(pulled(0.5)));
  const ReplayResult near = pulled(0.01);
  EXPECT_TRUE(is_told(near));
  EXPECT_NEAR(motion(near), motion(pulled(0)), 0.02 * motion(near));
}

TEST(MirrorKey, IsReadAndWritten) {
  for (const std::string& line : {kRotate, kPull, kPaint, kBend, kPins}) {
    const Session session = session_of({line});
    EXPECT_FALSE(session.strokes.front().mirror.empty());
    EXPECT_EQ(session_of({stroke_line(session.strokes.front())}).strokes, session.strokes) << line;
  }
  const auto written = [](const std::string& mirror) {
    std::string line = kPull;
    line.replace(line.find("\"x\""), 3, mirror);
    return stroke_line(session_of({line}).strokes.front());
  };
  EXPECT_NE(written(R"("zx")").find(R"("mirror": "xz")"), std::string::npos);
  EXPECT_NE(written(R"({"normal": [1, 0, 0], "point": [0, 0, 0]})").find(R"("mirror": "x")"), std::string::npos);
  EXPECT_NE(written(R"({"normal": [1, 1, 0]})").find(R"("mirror": {"normal": [1, 1, 0]})"), std::string::npos);
  EXPECT_NE(written(R"([{"normal": [1, 1, 0], "point": [2, 0, 0]}, {"normal": [0, 0, 1]}])")
                .find(R"("mirror": [{"normal": [1, 1, 0], "point": [2, 0, 0]}, {"normal": [0, 0, 1]}])"),
            std::string::npos);
  EXPECT_EQ(stroke_line(session_of({kPull}).strokes.front()), stroke_line(parse_stroke(kPull, "x")));
}

TEST(MirrorKey, IsRefusedInOneLineThatNamesIt) {
  for (const std::string mirror :
       {R"("w")", R"("")", "1", "null", "[]", "{}", R"({"normal": [0, 0, 0]})", R"({"normal": [1, 0]})",
        R"({"normal": [1, 0, 0], "axis": 1})", R"([{"normal": [1, 0, 0]}, {"normal": [1, 1, 0]}])", R"(["x"])"}) {
    std::string line = kPull;
    line.replace(line.find("\"x\""), 3, mirror);
    try {
      session_of({line});
      ADD_FAILURE() << mirror;
    } catch (const InvalidInput& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.find("s.knead:2: "), 0U) << text;
      EXPECT_NE(text.find("mirror"), std::string::npos) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    }
  }
  EXPECT_THROW(session_of({R"({"relax": {"points": [[0, 0, 0]], "radius": 1, "mirror": "x"}})"}), InvalidInput);
  EXPECT_THROW(session_of({R"({"mask": {"points": [[0, 0, 0]], "width": 1, "mirror": "x"}})"}), InvalidInput);
}

TEST(MirrorKey, TheSidesOfAShapeAreMirrorImages) {
  const Mesh mesh = sphere();
  for (const std::string& line : {kRotate, kPull, kBend, kPins}) {
    const Session session = session_of({line});
    const std::vector<Vec3d> moved = replayed(mesh, session);
    EXPECT_GT(test::greatest_distance(moved, mesh.positions), 0.05) << line;
    Mesh image = flipped(mesh);
    image.positions = replayed(image, session);
    EXPECT_LT(test::greatest_distance(flipped(image).positions, moved), 1e-12) << line;
  }
}

TEST(MirrorKey, AResolvedSessionGivesTheSameBits) {
  const Mesh mesh = sphere();
  const std::string part =
      R"({"tool": "paint", "mirror": "x", "strength": 0.4, "outer": 0.4, "depth": 0.1, "path": [[0.1, 0.9, 0.3], [0.6, 0.7, 0.4]]})";
  const std::string automatic =
      R"({"tool": "twist", "mirror": "x", "center": [0.6, 0, 0], "axis": [-1, 0, 0], "rate_deg": 30, "inner": -0.2, "outer": 0.1, "radius": "auto"})";
  const std::string handles =
      R"({"tool": "handles", "mirror": "x", "full_vertices": [3, 5], "zero_vertices": [100], "motion": {"translate": [0.1, 0, 0]}})";
  const Session session = session_of({kPaint, kRotate, part, automatic, handles, kPull});
  const ReplayResult result = replay(mesh, session, {});
  Session resolved;
  resolved.name = "r.knead";
  resolved.strokes = result.resolved;
  const Session read = parse_session(serialize_session(resolved), "r.knead");
  EXPECT_EQ(replay(mesh, read, {}).shape.positions(), result.shape.positions());
  std::vector<Vec3d> moved = mesh.positions;
  for (const SessionStroke& stroke : read.strokes) EXPECT_FALSE(reads_surface(stroke.stroke));
  EXPECT_TRUE(std::all_of(read.strokes.begin(), read.strokes.end(), [](const auto& s) { return !s.mirror.empty(); }));
}

TEST(MirrorKey, ComesBackThroughTheInverse) {
  const Mesh mesh = sphere();
  for (const std::string& line : {kRotate, kPull, kBend, kPins}) {
    const Session session = session_of({line});
    ReplayOptions options;
    options.motion.relative_tolerance = 1e-8;
    Mesh there = mesh;
    there.positions = replayed(mesh, session, options);
    options.part.direction = Direction::backwards;
    EXPECT_LT(test::greatest_distance(replayed(there, session, options), mesh.positions), 1e-5) << line;
  }
}

TEST(MirrorKey, BothSidesGrowTogetherInFrames) {
  const Mesh mesh = sphere();
  const Session session = session_of({kRotate});
  ReplayOptions options;
  options.motion.precision = Precision::float64;
  options.frames.count = 5;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    double left = 0;
    double right = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      double& side = mesh.positions[i].x < 0 ? left : right;
      side = std::max(side, norm(frame.shape.positions()[i] - mesh.positions[i]));
    }
    EXPECT_NEAR(left, right, 0.02) << frame.index;  // the vertices are no mirror images
    EXPECT_EQ(left > 0.01, frame.index > 0);
  };
  replay(mesh, session, options);
}

TEST(MirrorKey, AFlowOfTheSessionDoesTheSame) {
  const Mesh mesh = sphere();
  const Session session = session_of({kRotate, kPull});
  std::vector<Vec3d> moved = mesh.positions;
  const MotionOptions motion;
  advect(flow_of(session), moved, advect_options(motion, 1));
  EXPECT_LT(test::greatest_distance(moved, replay(mesh, session, {}).shape.positions()), 1e-4);
}

TEST(MirrorKey, RemeshingFollowsBothSides) {
  Session session = session_of({R"({"remesh": {}})", kPull});
  const ReplayResult result = replay(sphere(), session, {});
  double left = 0;
  double right = 0;
  for (const Vec3d& p : result.shape.positions()) {
    left = std::max(left, p.x < 0 ? norm(p) : 0);
    right = std::max(right, p.x > 0 ? norm(p) : 0);
  }
  EXPECT_GT(left, 1.2);
  EXPECT_NEAR(left, right, 0.02);
}

TEST(MirrorKey, AMaskHoldsWhereItIs) {
  const Mesh mesh = sphere();
  const Session session = session_of({R"({"mask": {"points": [[0.6, 0.8, 0], [0.7, 0.7, 0]], "width": 0.3}})", kPull});
  const std::vector<Vec3d> masked = replayed(mesh, session);
  const std::vector<Vec3d> free = replayed(mesh, session_of({kPull}));
  double left = 0;
  double right = 0;
  for (std::size_t i = 0; i < masked.size(); ++i) {
    double& side = mesh.positions[i].x < -0.5 ? left : right;
    side = std::max(side, norm(masked[i] - free[i]));
    EXPECT_EQ(masked[i].x == 0, mesh.positions[i].x == 0);
  }
  EXPECT_GT(right, 0.1);
  EXPECT_LT(left, 0.5 * right);
}

TEST(MirrorKey, OfALiveStrokeGrowsAsTheWholeStrokeDoes) {
  const Mesh mesh = sphere();
  SessionStroke stroke = session_of({kPull}).strokes.front();
  auto& path = std::get<ImplicitStroke>(stroke.stroke).path;
  const std::vector<Vec3d> whole = path;
  Workbench bench(mesh, {});
  for (std::size_t count = 2; count <= whole.size(); ++count) {
    path.assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(count));
    bench.set_live({stroke});
  }
  bench.finish();
  EXPECT_EQ(bench.state().positions.copy(), replay(mesh, session_of({kPull}), {}).shape.positions());
}

TEST(MirrorKey, StrokesGetMorePlanes) {
  const Session session = session_of({kPull});
  const std::vector<SessionStroke> both = mirrored_in(session.strokes, coordinate_mirror("xz"));
  EXPECT_EQ(both.front().mirror, coordinate_mirror("xz"));
  EXPECT_EQ(mirrored_in(session.strokes, {}), session.strokes);
  SessionStroke own{ImplicitStroke{{{0, 0, 0.5}, {0, 1, 0.5}}, 0.1, 0.4}};
  EXPECT_EQ(mirrored_in({own}, coordinate_mirror("x")).front(), own);
}

}  // namespace
}  // namespace knead::mirror_test
