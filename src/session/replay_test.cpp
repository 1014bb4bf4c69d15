// Replays: their result, parts, inverse, warnings and normals.
#include "knead/replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/test_shapes.h"

namespace knead::replay_test {
namespace {

Session session_of(std::vector<Stroke> strokes) {
  Session session;
  session.name = "s.knead";
  for (std::size_t i = 0; i < strokes.size(); ++i) session.strokes.push_back({std::move(strokes[i]), i + 2});
  return session;
}

Mesh bar() { return make_shape(ShapeKind::box, 1500); }

// Several segments, a limit cylinder, several fields in one segment.
Session varied() {
  PointsStroke points;
  points.points = {{-1, 0.5, 0}, {1, 0.5, 0.2}};
  points.outer = 0.8;
  points.displacements = {{0, 0.3, 0}, {0.2, 0, 0}};
  TwistStroke twist{{0, 0, 0}, {1, 0, 0}, 20, -1, 1};
  twist.radius = 1.5;
  BendStroke bend{{1, 0, 0}, {0, 1, 0}, {1, 0, 0}, 40, BendWidth{1.5}};
  bend.radius = 2;
  return session_of(
      {ImplicitStroke{{{-2, 0, 0}, {-2, 0.5, 0}, {-1.5, 0.7, 0.2}, {-1, 0.5, 0}}, 0.3, 0.9}, twist, points, bend});
}

std::vector<Vec3d> result_of(const Mesh& mesh, const Session& session, const ReplayOptions& options = {}) {
  const ReplayResult result = replay(mesh, session, options);
  EXPECT_EQ(result.status, AdvectStatus::done);
  return result.shape.positions();
}

// Reading the shape: the bar reaches 0.5 from the line.
TEST(Replay, WarnsOfABendOverAThinZone) {
  BendStroke bend{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 42, BendWidth{0.1}};
  const std::vector<std::string> warnings = replay(bar(), session_of({bend})).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("s.knead:2: the zone of the bend is 0.1 wide")) << warnings[0];
  EXPECT_NE(warnings[0].find("make the zone 0.88 wide"), std::string::npos) << warnings[0];
  bend.extent = BendWidth{0.9};
  for (const std::string& warning : replay(bar(), session_of({bend})).warnings) {
    EXPECT_EQ(warning.find("the zone of the bend"), std::string::npos) << warning;
  }
}

TEST(Replay, IsTheFlowsOfItsStrokesOneAfterTheOther) {
  const Mesh mesh = bar();
  const Session session = varied();
  std::vector<Vec3d> expected = mesh.positions;
  std::vector<std::uint32_t> steps(expected.size());
  AdvectOptions options;
  options.tolerance = 1e-5 * bounding_box(mesh.positions).diagonal();
  options.steps = steps;
  AdvectResult total;
  for (const SessionStroke& stroke : session.strokes) total += advect(flow_of(stroke.stroke), expected, options);
  const ReplayResult result = replay(mesh, session);
  EXPECT_EQ(result.shape.positions(), expected);
  EXPECT_EQ(result.shape.steps(), steps);
  EXPECT_EQ(result.shape.work().accepted_steps, total.accepted_steps);
  EXPECT_EQ(result.shape.work().rejected_steps, total.rejected_steps);
  EXPECT_EQ(result.shape.work().evaluations, total.evaluations);
  EXPECT_EQ(result.strokes, 4u);
  EXPECT_EQ(result.segments, 7u);
  EXPECT_EQ(result.resolved, session.strokes);
}

TEST(Replay, OfNothingLeavesEveryBit) {
  const Mesh mesh = bar();
  EXPECT_EQ(result_of(mesh, session_of({})), mesh.positions);
  EXPECT_TRUE(result_of({}, varied()).empty());
}

TEST(Replay, DoesNotDependOnThreadsOrTheOrderOfVertices) {
  Mesh mesh = bar();
  ReplayOptions one;
  one.motion.threads = 1;
  ReplayOptions two;
  two.motion.threads = 2;
  const std::vector<Vec3d> expected = result_of(mesh, varied(), one);
  EXPECT_EQ(result_of(mesh, varied(), two), expected);
  std::vector<std::uint32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(5));
  std::vector<std::uint32_t> place(order.size());
  const std::vector<Vec3d> original = mesh.positions;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    mesh.positions[i] = original[order[i]];
    place[order[i]] = i;
  }
  for (std::uint32_t& vertex : mesh.corner_vertex) vertex = place[vertex];
  const std::vector<Vec3d> shuffled = result_of(mesh, varied(), two);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(shuffled[i], expected[order[i]]);
}

TEST(Replay, StopsWithinAStroke) {
  const Mesh mesh = bar();
  const Session session = varied();
  for (const double until : {0.0, 0.5, 1.0, 2.5, 3.75, 4.0}) {
    std::vector<Vec3d> expected = mesh.positions;
    AdvectOptions options;
    options.tolerance = 1e-5 * bounding_box(mesh.positions).diagonal();
    for (std::size_t i = 0; i < 4; ++i) {
      const Flow flow = flow_of(session.strokes[i].stroke);
      const double part = std::clamp(until - static_cast<double>(i), 0.0, 1.0);
      advect(prefix(flow, part * static_cast<double>(flow.segments.size())), expected, options);
    }
    ReplayOptions replay_options;
    replay_options.part.until = until;
    EXPECT_EQ(result_of(mesh, session, replay_options), expected) << until;
    EXPECT_EQ(replay(mesh, session, replay_options).strokes, static_cast<std::size_t>(std::ceil(until)));
  }
}

// Every one of 7 segments may err by the tolerance, and errors grow with the flow's stretch, here by less than 10.
TEST(Replay, InverseReturns) {
  Mesh mesh = bar();
  const std::vector<Vec3d> before = mesh.positions;
  const double tolerance = 1e-7;
  for (const std::optional<double> until : {std::optional<double>{}, std::optional<double>{2.5}}) {
    ReplayOptions options;
    options.motion.precision = Precision::float64;
    options.motion.relative_tolerance = tolerance;
    options.part.until = until;
    mesh.positions = before;
    mesh.positions = result_of(mesh, varied(), options);
    EXPECT_NE(mesh.positions, before);
    options.part.direction = Direction::backwards;
    const std::vector<Vec3d> back = result_of(mesh, varied(), options);
    double worst = 0;
    for (std::size_t i = 0; i < back.size(); ++i) worst = std::max(worst, norm(back[i] - before[i]));
    EXPECT_LT(worst, 2 * 7 * 10 * tolerance * bounding_box(before).diagonal());
  }
}

void expect_frames(const Mesh& mesh, ReplayOptions options, int frames) {
  std::vector<std::vector<Vec3d>> delivered;
  options.frames.count = frames;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    EXPECT_EQ(frame.index, static_cast<int>(delivered.size()));
    delivered.emplace_back(frame.shape.positions().begin(), frame.shape.positions().end());
  };
  Progress progress;
  options.progress = &progress;
  const std::uint64_t total = Replay(borrow(mesh), varied(), options).work();
  const std::vector<Vec3d> result = result_of(mesh, varied(), options);
  EXPECT_EQ(progress.done, total);
  ASSERT_EQ(delivered.size(), static_cast<std::size_t>(frames));
  EXPECT_EQ(delivered.back(), result);
  options.frames.count = 0;
  options.progress = nullptr;
  EXPECT_EQ(result, result_of(mesh, varied(), options));
  if (options.part.direction == Direction::backwards) return;
  const double end = options.part.until.value_or(4);
  for (int k = 0; k + 1 < frames; ++k) {
    options.part.until = end * k / (frames - 1);
    EXPECT_EQ(delivered[k], result_of(mesh, varied(), options)) << "frame " << k << " of " << frames;
  }
}

TEST(Replay, FramesAreWhatUntilTheirMomentGives) {
  const Mesh mesh = bar();
  for (const int frames : {1, 2, 5, 14}) {
    expect_frames(mesh, {}, frames);
    ReplayOptions part;
    part.part.until = 2.3;
    expect_frames(mesh, part, frames);
    ReplayOptions back;
    back.part.direction = Direction::backwards;
    back.part.until = 1.5;
    expect_frames(mesh, back, frames);
  }
}

TEST(Replay, FramesOfTheInverseGoBackTheSameWay) {
  Mesh mesh = bar();
  ReplayOptions options;
  options.motion.precision = Precision::float64;
  options.motion.relative_tolerance = 1e-7;
  options.frames.count = 9;
  std::vector<std::vector<Vec3d>> there;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    there.emplace_back(frame.shape.positions().begin(), frame.shape.positions().end());
  };
  mesh.positions = result_of(mesh, varied(), options);
  int met = 0;
  options.part.direction = Direction::backwards;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    const std::span<const Vec3d> p = frame.shape.positions();
    for (std::size_t i = 0; i < p.size(); ++i) EXPECT_LT(norm(p[i] - there[8 - frame.index][i]), 1e-4);
    ++met;
  };
  replay(mesh, varied(), options);
  EXPECT_EQ(met, 9);
}

TEST(Replay, CancelsAndLeavesTheMesh) {
  const Mesh mesh = bar();
  const std::vector<Vec3d> before = mesh.positions;
  Progress progress;
  ReplayOptions options;
  options.progress = &progress;
  options.frames.count = 9;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    if (frame.index == 3) progress.cancel = true;
    EXPECT_LE(frame.index, 3);
  };
  const ReplayResult result = replay(mesh, varied(), options);
  EXPECT_EQ(result.status, AdvectStatus::cancelled);
  EXPECT_TRUE(result.shape.positions().empty());
  EXPECT_EQ(mesh.positions, before);
}

std::string refusal(const Mesh& mesh, const Session& session, const ReplayOptions& options = {}) {
  try {
    replay(mesh, session, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Replay, RefusesACutLimitCylinderAndTheRadiusItNamesWorks) {
  const Mesh mesh = bar();
  BendStroke bend{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 40, BendWidth{1}};
  bend.radius = 0.4;
  const StretchStroke first{{0, 0, 0}, {1, 0, 0}, 1.1, 0.2, 0.5};
  const std::string message = refusal(mesh, session_of({first, bend}));
  EXPECT_TRUE(message.starts_with("s.knead:3: ")) << message;
  const std::size_t at = message.find("use \"radius\": ");
  ASSERT_NE(at, std::string::npos) << message;
  bend.radius = std::stod(message.substr(at + 14));
  EXPECT_GT(*bend.radius, 0.7);  // the bar's corners are 0.7071 from its axis
  EXPECT_LT(*bend.radius, 0.8);
  EXPECT_EQ(refusal(mesh, session_of({first, bend})), "");
}

TEST(Replay, RefusesACutLimitCylinderBackwardsToo) {
  Mesh mesh = bar();
  BendStroke bend{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 40, BendWidth{1}};
  mesh.positions = result_of(mesh, session_of({bend}));
  bend.radius = 0.4;
  ReplayOptions options;
  options.part.direction = Direction::backwards;
  EXPECT_TRUE(refusal(mesh, session_of({bend}), options).starts_with("s.knead:2: "));
  bend.radius = 0.8;
  EXPECT_EQ(refusal(mesh, session_of({bend}), options), "");
}

TEST(Replay, RefusesOptionsOutOfRange) {
  const Mesh mesh = bar();
  const auto with = [&](const auto& change) {
    ReplayOptions options;
    change(options);
    return refusal(mesh, varied(), options);
  };
  EXPECT_TRUE(with([](ReplayOptions& o) { o.part.until = 4.5; }).starts_with("\"until\" must be from 0"));
  EXPECT_TRUE(with([](ReplayOptions& o) { o.part.until = -1; }).starts_with("\"until\""));
  EXPECT_TRUE(with([](ReplayOptions& o) { o.part.until = std::nan(""); }).starts_with("\"until\""));
  EXPECT_TRUE(with([](ReplayOptions& o) { o.motion.relative_tolerance = 0; }).starts_with("the tolerance"));
  EXPECT_TRUE(with([](ReplayOptions& o) { o.frames.count = -1; }).starts_with("the number of frames"));
  EXPECT_TRUE(with([](ReplayOptions& o) { o.motion.threads = -1; }).starts_with("the number of threads"));
}

TEST(Replay, RefusesAMeshThatIsNone) {
  Mesh beyond = bar();
  beyond.corner_vertex[10] = 1'000'000;
  Mesh nowhere = bar();
  nowhere.positions[3].x = std::nan("");
  for (const bool remeshed : {false, true}) {
    ReplayOptions options;
    if (remeshed) options.remesh.settings.emplace();
    EXPECT_THROW(replay(beyond, varied(), options), InvalidInput);
    EXPECT_THROW(replay(nowhere, varied(), options), InvalidInput);
  }
}

TEST(Replay, NamesTheLineOfAStrokeThatOverflows) {
  const Session session = session_of({ImplicitStroke{{{-1e308, 0, 0}, {1e308, 0, 0}}, 1, 2}});
  EXPECT_TRUE(refusal(bar(), session).starts_with("s.knead:2: "));
}

// A prism of two rings of vertices collapses in a twist by 360 degrees; remeshed it does not.
TEST(Replay, WarnsOfEdgesThatReachOverALargePartOfATwist) {
  const auto long_edges = [](std::size_t vertices, bool remesh) {
    Session session = session_of({TwistStroke{{0, 0, 0}, {1, 0, 0}, 60, -3, 3}});
    if (remesh) session.strokes[0].remesh = RemeshSettings{};
    Mesh mesh = vertices == 8 ? unit_cube() : make_shape(ShapeKind::box, vertices);
    for (Vec3d& p : mesh.positions) p.x *= vertices == 8 ? 6 : 1;
    const std::vector<std::string> warnings = replay(mesh, session).warnings;
    return std::count_if(warnings.begin(), warnings.end(),
                         [](const std::string& text) { return text.find("remesh the shape") != std::string::npos; });
  };
  EXPECT_EQ(long_edges(8, false), 1);
  EXPECT_EQ(long_edges(8, true), 0);
  EXPECT_EQ(long_edges(6000, false), 0);
}

TEST(Replay, WarnsWithTheLine) {
  const Session session = session_of({ImplicitStroke{{{-1, 0, 90}, {1, 0, 90}}, 0.95, 1}});
  ReplayOptions options;
  options.motion.relative_tolerance = 1e-7;
  const std::vector<std::string> warnings = replay(bar(), session, options).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("use double precision"), std::string::npos);
  EXPECT_TRUE(warnings[1].starts_with("s.knead:2: \"inner\" is 0.95 of \"outer\"")) << warnings[1];
  EXPECT_EQ(Replay(borrow(bar()), session, options).warnings(), std::vector<std::string>{warnings[1]});
}

// The limit cylinder's image after the bend reaches beyond the fingertip over the next fingers, which never moved: only
// the surface tells which vertices came from within it.
TEST(Replay, TakesBackABentFingerAndNothingElse) {
  const Mesh hand = make_shape(ShapeKind::hand, 8000);
  const Session session = parse_session(
      "{\"knead\": 1}\n"
      R"({"tool": "bend", "center": [0.112, 0.65, 0], "axis": [0, 0, 1], "normal": [0, -1, 0], "width": 0.3,)"
      R"( "angle_deg": -60, "radius": 0.1165})"
      "\n",
      "finger.knead");
  ReplayOptions options;
  Mesh bent = hand;
  bent.positions = replay(hand, session, options).shape.positions();
  options.part.direction = Direction::backwards;
  options.frames.count = 3;
  std::vector<Vec3d> first;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    if (frame.index == 0) first.assign(frame.shape.positions().begin(), frame.shape.positions().end());
  };
  const auto back = replay(bent, session, options).shape.positions();
  const double diagonal = bounding_box(hand.positions).diagonal();
  for (std::size_t i = 0; i < back.size(); ++i) {
    ASSERT_LT(norm(back[i] - hand.positions[i]), 2e-5 * diagonal) << "vertex " << i;
    ASSERT_EQ(first[i], bent.positions[i]);
  }
}

// Far out in the slab of a bend the inverse runs away; frames before the end do not hide that.
TEST(Replay, ReportsAPathLineThatRunsAwayBackwardsWithFramesToo) {
  Mesh points;
  points.positions = make_shape(ShapeKind::sphere, 2000).positions;
  BendStroke bend{{0.109, 0.55, -0.012}, {1, 0, 0}, {0, -1, 0}, 80, BendWidth{0.35}};
  bend.radius = 0.125;
  for (const int frames : {0, 3}) {
    ReplayOptions options;
    options.part.direction = Direction::backwards;
    options.frames.count = frames;
    const ReplayResult result = replay(points, session_of({bend}), options);
    EXPECT_EQ(result.status, AdvectStatus::step_limit) << frames;
    EXPECT_EQ(result.failed_line, 2u);
  }
}

std::vector<Vec3d> random_units(std::size_t count) {
  std::mt19937 random(7);
  std::normal_distribution<double> number;
  std::vector<Vec3d> units;
  for (std::size_t i = 0; i < count; ++i)
    units.push_back(normalized(Vec3d{number(random), number(random), number(random)}));
  return units;
}

// Inside the inner region of a rotation everything turns by its angle; outside nothing does.
TEST(Replay, NormalsOfPointsTurnWithARotation) {
  Mesh points;
  for (int i = 0; i < 40; ++i) points.positions.push_back({0.05 * i - 1, 0.1, 0.02 * i});
  std::vector<Vec3d> normals = random_units(points.positions.size());
  for (Vec3d& n : normals) n = n * 3.0;
  normals[5] = {};
  ReplayOptions options;
  options.normals = normals;
  RotateStroke rotate;
  rotate.center = {0, 0, 0};
  rotate.axis = {0, 0, 1};
  rotate.angle_deg = 90;
  rotate.inner = 0.6;
  rotate.outer = 0.9;
  const ReplayResult result = replay(points, session_of({rotate}), options);
  ASSERT_EQ(result.shape.normals().size(), normals.size());
  std::size_t inside = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double distance = norm(points.positions[i]);
    if (distance > 0.91) {
      EXPECT_EQ(result.shape.normals()[i], normals[i]);
    }
    if (distance < 0.59) {
      ++inside;
      EXPECT_LT(norm(result.shape.normals()[i] - Vec3d{-normals[i].y, normals[i].x, normals[i].z}), 1e-4);
    }
    EXPECT_NEAR(norm(result.shape.normals()[i]), norm(normals[i]), 1e-12);
  }
  EXPECT_GT(inside, 10u);
  EXPECT_EQ(result.shape.normals()[5], Vec3d{});
}

// Against the normals of a fine sphere's faces, which the points lie on; and back again.
TEST(Replay, NormalsOfPointsStayThoseOfTheSurface) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 40000);
  Mesh points;
  std::vector<Vec3d> normals;
  for (std::size_t i = 0; i < sphere.positions.size(); i += 97) {
    points.positions.push_back(sphere.positions[i]);
    normals.push_back(normalized(sphere.positions[i]));
  }
  const Session session =
      session_of({ImplicitStroke{{{0, 0, 1}, {0, 0.2, 1.3}, {0.1, 0.4, 1.6}, {0.2, 0.5, 1.8}}, 0.2, 0.7},
                  TwistStroke{{0, 0, -0.2}, {0, 0, 1}, 60, -0.5, 0.5}});
  ReplayOptions options;
  options.motion.precision = Precision::float64;  // how accurate the points are is not the question here
  options.motion.relative_tolerance = 1e-9;
  options.normals = normals;
  const ReplayResult carried = replay(points, session, options);
  const std::vector<Vec3d> of_faces = vertex_normals(sphere, result_of(sphere, session));
  for (std::size_t k = 0; k < normals.size(); ++k) {
    EXPECT_GT(dot(carried.shape.normals()[k], of_faces[97 * k]), 1 - 2e-3)
        << k;  // the facets' own error: 1/200 of the radius
  }
  points.positions = carried.shape.positions();
  options.normals = carried.shape.normals();
  options.part.direction = Direction::backwards;
  const ReplayResult back = replay(points, session, options);
  for (std::size_t k = 0; k < normals.size(); ++k) EXPECT_LT(norm(back.shape.normals()[k] - normals[k]), 1e-3) << k;
}

TEST(Replay, NormalsOfFramesAreThoseOfTheirMoment) {
  Mesh points;
  points.positions = bar().positions;
  const std::vector<Vec3d> normals = random_units(points.positions.size());
  for (const bool inverse : {false, true}) {
    ReplayOptions options;
    options.normals = normals;
    options.part.direction = inverse ? Direction::backwards : Direction::forwards;
    options.frames.count = 5;
    std::vector<Vec3d> last;
    int changed = 0;
    options.frames.deliver = [&](const ReplayFrame& frame) {
      const std::vector<Vec3d> of_frame = frame.shape.normals();
      ASSERT_EQ(of_frame.size(), normals.size());
      if (!last.empty() && !std::equal(last.begin(), last.end(), of_frame.begin())) ++changed;
      last.assign(of_frame.begin(), of_frame.end());
    };
    const ReplayResult result = replay(points, varied(), options);
    EXPECT_EQ(result.shape.normals(), last);
    EXPECT_EQ(changed, 4);
  }
}

}  // namespace
}  // namespace knead::replay_test
