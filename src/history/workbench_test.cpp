// Compares the shape of a workbench with a replay of its session.
#include "knead/editor/workbench.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "support/scratch.h"

namespace knead::workbench_test {
namespace {

Mesh ball() { return make_shape(ShapeKind::sphere, 2562); }

std::vector<SessionStroke> session_strokes(const std::vector<Stroke>& strokes) {
  std::vector<SessionStroke> result;
  for (const Stroke& stroke : strokes) result.push_back({stroke});
  return result;
}

ReplayResult replayed(const Mesh& mesh, const std::vector<SessionStroke>& strokes,
                      const std::filesystem::path& folder = {}) {
  Session session;
  session.name = (folder / "s.knead").string();
  session.strokes = strokes;
  return replay(mesh, session);
}

void expect_as_replayed(const Workbench& bench, const Mesh& base, const std::filesystem::path& folder = {}) {
  const ReplayResult expected = replayed(base, bench.strokes(), folder);
  EXPECT_TRUE(bench.state().positions.copy() == expected.shape.positions());
  const Mesh mesh = bench.state().to_mesh();
  EXPECT_EQ(mesh.corner_vertex, expected.shape.mesh().corner_vertex);
  if (expected.shape.is_remeshed()) {
    EXPECT_EQ(bench.state().provenance->face_source, expected.shape.provenance()->face_source);
  }
}

// The lines of a session file that follows the changes.
struct Lines {
  std::vector<SessionStroke> strokes;

  void follow(const LineChange& change) {
    ASSERT_LE(change.undone, strokes.size());
    strokes.resize(strokes.size() - change.undone);
    strokes.insert(strokes.end(), change.appended.begin(), change.appended.end());
  }
};

ImplicitStroke pull(std::size_t points, double x = 1) {
  ImplicitStroke stroke{{}, 0.15, 0.5};
  for (std::size_t i = 0; i < points; ++i) {
    const auto t = static_cast<double>(i);
    stroke.path.push_back({x + 0.05 * t, 0.02 * t, 0.01 * t * t});
  }
  return stroke;
}

std::vector<Stroke> growing(const std::string& tool, std::size_t n) {
  if (tool == "implicit") return {pull(n + 1)};
  if (tool == "paint") {
    PaintStroke stroke{0.3, 0.03, {}};
    for (std::size_t i = 0; i < n; ++i) {
      const double t = 0.1 * static_cast<double>(i);
      stroke.samples.push_back({{std::cos(t), std::sin(t), 0}, {std::cos(t), std::sin(t), 0}});
    }
    return {stroke};
  }
  if (tool == "points") {
    PointsStroke stroke;
    stroke.points = {{0, 1, 0}, {0.1, 1, 0}};
    stroke.curves = {{{0.5, 0.8, 0}, {0.6, 0.7, 0.1}, {0.7, 0.7, 0.2}}};
    stroke.outer = 0.3;
    stroke.displacements.assign(n, {0.01, 0.04, 0});
    return {stroke};
  }
  if (tool == "rotate") return {RotateStroke{{1, 0, 0}, {1, 0, 0.2}, 10.0 * static_cast<double>(n), 0.2, 0.7}};
  if (tool == "mirrored") {
    std::vector<Stroke> strokes;
    ImplicitStroke whole = pull(n + 1, 0.1);
    for (Vec3d& p : whole.path) p.y += 0.95;  // the two sides meet
    for (std::size_t i = 0; i < n; ++i) {
      ImplicitStroke piece = whole;
      piece.path = {whole.path[i], whole.path[i + 1]};
      strokes.push_back(piece);
      strokes.push_back(mirrored(piece, 0));
    }
    return strokes;
  }
  HandlesStroke stroke;
  stroke.full = {{0, 1, 0}, {0.1, 0.99, 0}};
  stroke.zero = {{0, -1, 0}, {1, 0, 0}, {-1, 0, 0}};
  stroke.motion = HandlesTranslation{{0, 0.05 * static_cast<double>(n), 0}};
  return {stroke};
}

class LiveTool : public testing::TestWithParam<const char*> {};

TEST_P(LiveTool, HasTheBitsOfAReplayAtEveryMomentAndSoDoItsLines) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  Lines lines;
  for (std::size_t n = 1; n <= 5; ++n) {
    const WorkResult result = bench.set_live(session_strokes(growing(GetParam(), n)));
    ASSERT_TRUE(result.is_done()) << result.refusal;
    lines.follow(result.lines);
    expect_as_replayed(bench, mesh);
    EXPECT_TRUE(replayed(mesh, lines.strokes).shape.positions() == bench.state().positions.copy());
  }
  EXPECT_FALSE(bench.state().positions.changes_since(bench.base().positions).empty());
  lines.follow(bench.finish().lines);
  ASSERT_EQ(bench.done().size(), 1u);
  expect_as_replayed(bench, mesh);
  EXPECT_TRUE(replayed(mesh, lines.strokes).shape.positions() == bench.state().positions.copy());
  // Of the lines, gestures are known again.
  EXPECT_EQ(strokes_of_gestures(lines.strokes).size(), 1u);
  EXPECT_EQ(joined_strokes(strokes_of_gestures(lines.strokes)[0]), bench.done()[0]->strokes);
}

INSTANTIATE_TEST_SUITE_P(Workbench, LiveTool,
                         testing::Values("implicit", "paint", "points", "rotate", "handles", "mirrored"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Workbench, LinesOfAGestureKeepStrengthNameAndOff) {
  const Mesh base = ball();
  Workbench bench(base);
  Lines lines;
  lines.follow(bench.set_live({{pull(2)}}).lines);
  SessionStroke half{pull(3)};
  half.strength = 0.5;
  half.name = "half";
  SessionStroke off{pull(3, -1)};
  off.off = true;
  lines.follow(bench.set_live({half, off}).lines);
  SessionStroke marked = off;  // it would look like an entry of its own
  marked.new_entry = false;
  EXPECT_EQ(lines.strokes, (std::vector<SessionStroke>{half, marked}));
  lines.follow(bench.finish().lines);
  expect_as_replayed(bench, base);
  EXPECT_EQ(replayed(base, lines.strokes).shape.positions(), bench.state().positions.copy());
}

TEST(Workbench, ALiveStrokeThatBecomesAnotherBeginsAnew) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  Lines lines;
  for (const auto& strokes : {growing("implicit", 3), growing("implicit", 2), growing("rotate", 1),
                              growing("implicit", 1), growing("mirrored", 3), growing("mirrored", 2)}) {
    lines.follow(bench.set_live(session_strokes(strokes)).lines);
    expect_as_replayed(bench, mesh);
    EXPECT_TRUE(replayed(mesh, lines.strokes).shape.positions() == bench.state().positions.copy());
  }
  lines.follow(bench.set_live({}).lines);
  EXPECT_TRUE(lines.strokes.empty());
  EXPECT_TRUE(bench.state().positions.changes_since(bench.base().positions).empty());
  EXPECT_TRUE(bench.finish().lines.empty());
  EXPECT_TRUE(bench.done().empty());
}

TEST(Workbench, UndoAndRedoGoThroughEverythingAndLinesFollow) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  Lines lines;
  std::vector<std::vector<Vec3d>> states{mesh.positions};
  for (const char* tool : {"implicit", "rotate", "paint", "points"}) {
    lines.follow(bench.set_live(session_strokes(growing(tool, 3))).lines);
    lines.follow(bench.finish().lines);
    states.push_back(bench.state().positions.copy());
  }
  for (std::size_t i = 4; i-- > 0;) {
    ASSERT_TRUE(bench.can_undo());
    lines.follow(bench.undo().lines);
    EXPECT_TRUE(bench.state().positions.copy() == states[i]);
    EXPECT_TRUE(replayed(mesh, lines.strokes).shape.positions() == states[i]);
    EXPECT_EQ(bench.redoable().size(), 4 - i);
  }
  EXPECT_FALSE(bench.can_undo());
  EXPECT_TRUE(bench.undo().lines.empty());
  for (std::size_t i = 1; i <= 4; ++i) {
    lines.follow(bench.redo().lines);
    EXPECT_TRUE(bench.state().positions.copy() == states[i]);
    EXPECT_TRUE(replayed(mesh, lines.strokes).shape.positions() == states[i]);
  }
  EXPECT_FALSE(bench.can_redo());
  bench.undo();
  bench.undo();
  bench.set_live(session_strokes(growing("rotate", 2)));
  bench.finish();
  EXPECT_FALSE(bench.can_redo());
  expect_as_replayed(bench, mesh);
}

TEST(Workbench, UndoDuringAGestureGivesUpTheGesture) {
  Workbench bench(ball());
  bench.set_live(session_strokes(growing("implicit", 2)));
  bench.finish();
  const std::vector<Vec3d> before = bench.state().positions.copy();
  bench.set_live(session_strokes(growing("rotate", 2)));
  bench.undo();
  EXPECT_TRUE(bench.live().empty());
  EXPECT_TRUE(bench.state().positions.copy() == before);
  EXPECT_EQ(bench.done().size(), 1u);
}

TEST(Workbench, AnEntryIsChangedUnderThoseThatFollow) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  Lines lines;
  for (const char* tool : {"implicit", "rotate", "points"}) {
    lines.follow(bench.set_live(session_strokes(growing(tool, 3))).lines);
    lines.follow(bench.finish().lines);
  }
  const std::vector<Vec3d> before = bench.state().positions.copy();
  lines.follow(bench.edit(1, session_strokes(growing("rotate", 6))).lines);
  expect_as_replayed(bench, mesh);
  EXPECT_FALSE(bench.state().positions.copy() == before);
  EXPECT_TRUE(replayed(mesh, lines.strokes).shape.positions() == bench.state().positions.copy());
  ASSERT_EQ(bench.done().size(), 3u);
  EXPECT_EQ(std::get<RotateStroke>(bench.done()[1]->strokes[0].stroke).angle_deg, 60);
  lines.follow(bench.edit(0, {}).lines);
  EXPECT_EQ(bench.done().size(), 2u);
  expect_as_replayed(bench, mesh);
  lines.follow(bench.undo().lines);
  lines.follow(bench.undo().lines);
  EXPECT_TRUE(bench.state().positions.copy() == before);
  EXPECT_TRUE(replayed(mesh, lines.strokes).shape.positions() == before);
  EXPECT_THROW(bench.edit(3, {}), std::out_of_range);
}

// A drag asks again at every batch; what an earlier place of the pointer gave is no longer true.
TEST(Workbench, WarnsOfAGestureAsItIsAtItsEnd) {
  Workbench bench(ball());
  const auto drag = [&](double way) {
    PinsStroke pins{{{0, 0, 1}, {0.3, 0, 1}}, {{0, 0, 1}, {0.3 - way, 0.01, 1}}, 1.0};
    EXPECT_TRUE(bench.set_live(session_strokes({pins})).is_done());
  };
  for (const double way : {0.1, 0.25, 0.28, 0.29}) drag(way);
  EXPECT_TRUE(bench.finish().is_done());
  EXPECT_EQ(bench.done().back()->notes.warnings.size(), 1U);
  for (const double way : {0.1, 0.25, 0.28, 0.29, 0.05}) drag(way);
  EXPECT_TRUE(bench.finish().is_done());
  EXPECT_TRUE(bench.done().back()->notes.warnings.empty());
}

TEST(Workbench, WhatCannotBeDoneLeavesTheShapeAsItWas) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  bench.set_live(session_strokes(growing("implicit", 2)));
  bench.finish();
  const std::vector<Vec3d> before = bench.state().positions.copy();
  TwistStroke twist{{0, 0, 0}, {0, 1, 0}, 50, -0.5, 0.5};
  twist.radius = 0.5;  // cuts the ball's triangles
  const WorkResult refused = bench.set_live({{twist}});
  EXPECT_NE(refused.refusal.find("would be torn"), std::string::npos) << refused.refusal;
  EXPECT_TRUE(refused.lines.empty());
  EXPECT_TRUE(bench.state().positions.copy() == before);
  Progress progress;
  progress.cancel = true;
  EXPECT_EQ(bench.set_live(session_strokes(growing("rotate", 2)), &progress).status, AdvectStatus::cancelled);
  EXPECT_EQ(bench.edit(0, session_strokes(growing("rotate", 2)), &progress).status, AdvectStatus::cancelled);
  EXPECT_TRUE(bench.state().positions.copy() == before);
  bench.set_live(session_strokes(growing("rotate", 2)));
  expect_as_replayed(bench, mesh);
}

TEST(Workbench, RemeshesWhenAGestureIsFinishedAsAReplayDoes) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  Lines lines;
  for (const char* tool : {"implicit", "rotate", "mirrored"}) {
    std::vector<SessionStroke> strokes = session_strokes(growing(tool, 5));
    for (SessionStroke& stroke : strokes) stroke.remesh = RemeshSettings{};
    lines.follow(bench.set_live(strokes).lines);
    const WorkResult result = bench.finish();
    ASSERT_TRUE(result.is_done());
    lines.follow(result.lines);
    expect_as_replayed(bench, mesh);
    EXPECT_EQ(lines.strokes, bench.strokes());
  }
  EXPECT_GT(bench.state().positions.size(), mesh.vertex_count());
  bench.set_live(session_strokes(growing("paint", 3)));
  bench.finish();
  expect_as_replayed(bench, mesh);
  while (bench.can_undo()) bench.undo();
  EXPECT_TRUE(bench.state().positions.copy() == mesh.positions);
  while (bench.can_redo()) bench.redo();
  expect_as_replayed(bench, mesh);
}

TEST(Workbench, StampsAndPaintingAlongAPathAreDoneAsAReplayDoesThem) {
  const test::Scratch scratch("workbench");
  const std::filesystem::path& folder = scratch.path();
  write_mesh(folder / "tool.ply", make_shape(ShapeKind::sphere, 162), {true, {}});
  const Mesh mesh = ball();
  Workbench bench(mesh, folder);
  StampStroke stamp;
  stamp.mesh = "tool.ply";
  stamp.pose = {{0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.3}};
  stamp.path = {{0, 1.35, 0}, {0, 1.2, 0}};
  StampStroke further = stamp;
  further.path = {{0, 1.2, 0}, {0, 1.1, 0}};
  PaintStroke groove{0.3, 0.05, {}, {{1.2, 0, -0.2}, {1.2, 0, 0.2}}};
  for (const std::vector<Stroke>& strokes :
       {std::vector<Stroke>{stamp}, std::vector<Stroke>{stamp, further}, std::vector<Stroke>{groove}}) {
    ASSERT_TRUE(bench.set_live(session_strokes(strokes)).is_done());
    expect_as_replayed(bench, mesh, folder);
  }
  EXPECT_FALSE(bench.state().positions.changes_since(bench.base().positions).empty());
}

// Splats change as a replay changes them once the gesture is settled; before, their centres move alone.
TEST(Workbench, SplatsAreDoneAsAReplayDoesThem) {
  Mesh mesh;
  mesh.positions = ball().positions;
  for (const char* name : {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    const std::vector<double> values(mesh.vertex_count(), std::string(name) == "rot_0" ? 1 : -3);
    mesh.attributes.push_back({name, Domain::vertex, NumberType::float32, 1, values});
  }
  Workbench bench(mesh);
  const auto expect_settled = [&] {
    EXPECT_TRUE(bench.is_settled());
    expect_as_replayed(bench, mesh);
    const DeformedShape shape = replayed(mesh, bench.strokes()).shape;
    EXPECT_EQ(bench.state().splats->splats, shape.splats()->splats);
    EXPECT_TRUE(bench.state().splats->jacobians == shape.splats()->jacobians);
    EXPECT_FALSE(shape.splats()->splats.empty() && !bench.done().empty());
  };
  for (int gesture = 0; gesture < 2; ++gesture) {
    const std::shared_ptr<const SplatJacobians> before = bench.state().splats;
    for (std::size_t points = 2; points < 8; ++points) bench.set_live({{pull(points, 1 - 2 * gesture)}});
    EXPECT_EQ(bench.state().splats, before);
    if (gesture == 0) {
      bench.finish();
    } else {
      bench.finish_later();
      EXPECT_FALSE(bench.is_settled());
      EXPECT_TRUE(bench.settle().is_done());
    }
    expect_settled();
  }
  const std::size_t all = bench.undo_memory().bytes;
  EXPECT_GT(all, bench.state().splats->splats.size() * sizeof(Mat3d));
  bench.undo();
  expect_settled();
  bench.undo();
  EXPECT_TRUE(bench.state().splats->splats.empty());
  bench.redo();
  bench.redo();
  expect_settled();
  bench.edit(0, {{pull(4, 1)}});
  expect_settled();
}

TEST(Workbench, StatesThatWereDroppedAreFoundAgain) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  bench.limit_memory(0);
  std::vector<std::vector<Vec3d>> states{mesh.positions};
  for (std::size_t n = 1; n <= 30; ++n) {
    bench.set_live(session_strokes({RotateStroke{{1, 0, 0.01 * static_cast<double>(n)}, {1, 0, 0}, 5, 0.2, 1.5}}));
    bench.finish();
    states.push_back(bench.state().positions.copy());
  }
  EXPECT_TRUE(bench.state_after(7)->positions.copy() == states[7]);
  for (std::size_t i = 30; i-- > 0;) {
    bench.undo();
    ASSERT_TRUE(bench.state().positions.copy() == states[i]) << i;
  }
}

TEST(Workbench, OpensASessionByGestures) {
  const Mesh mesh = ball();
  std::vector<SessionStroke> strokes = session_strokes(growing("mirrored", 4));
  for (const char* tool : {"implicit", "rotate"}) {
    for (const Stroke& stroke : growing(tool, 3)) strokes.push_back({stroke});
  }
  Workbench bench(mesh);
  ASSERT_TRUE(bench.append(strokes).is_done());
  EXPECT_EQ(bench.done().size(), 3u);
  EXPECT_TRUE(replayed(mesh, strokes).shape.positions() == bench.state().positions.copy());
  bench.undo();
  EXPECT_EQ(bench.done().size(), 2u);
}

// A pose that follows the pointer is about right, and exact at rest and at its end.
TEST(WorkbenchPose, FollowsAPointerAndEndsExactly) {
  const Mesh mesh = make_shape(ShapeKind::cylinder, 2000);
  const auto pose_to = [](double x) {
    PosePin moved;
    moved.point = Vec3d{0, 0.5, 1.9};
    moved.path = {{x, 0.5, 1.9 - 0.2 * x}};
    PosePin held;
    held.point = Vec3d{0, 0, -2};
    held.hold = true;
    PoseStroke stroke;
    stroke.parts = {moved, held};
    return session_strokes({stroke});
  };
  for (const bool rests : {true, false}) {
    for (const bool later : {true, false}) {
      Workbench bench(mesh);
      Lines lines;
      lines.follow(bench.set_live(session_strokes({pull(2)})).lines);
      lines.follow(bench.finish().lines);
      for (const double x : {0.1, 0.25, 0.4, 0.3}) lines.follow(bench.set_live(pose_to(x), nullptr, true).lines);
      const std::vector<Vec3d> about = bench.state().positions.copy();
      if (rests) {
        lines.follow(bench.set_live(pose_to(0.3)).lines);
        expect_as_replayed(bench, mesh);
        if (later) lines.follow(bench.set_live(pose_to(0.3), nullptr, true).lines);  // and on again
      }
      lines.follow((later ? bench.finish_later() : bench.finish()).lines);
      EXPECT_EQ(bench.is_settled(), !later);
      lines.follow(bench.settle().lines);
      EXPECT_TRUE(bench.is_settled());
      expect_as_replayed(bench, mesh);
      EXPECT_EQ(lines.strokes, bench.strokes());
      const std::vector<Vec3d> exact = bench.state().positions.copy();
      double apart = 0;
      for (std::size_t i = 0; i < exact.size(); ++i) apart = std::max(apart, norm(exact[i] - about[i]));
      EXPECT_GT(apart, 0);
      EXPECT_LT(apart, 0.05);
      bench.undo();
      EXPECT_TRUE(bench.state().positions.copy() == replayed(mesh, session_strokes({pull(2)})).shape.positions());
    }
  }
}

// Two pulls of which the second goes on where the first ended; one gesture of two strokes that do not belong together;
// two entries of one name. All look otherwise in a list of strokes.
TEST(Workbench, EntriesAreTheSameWhenTheirSessionIsOpenedAgain) {
  const Mesh mesh = ball();
  const auto continued = [](std::size_t begin) {
    ImplicitStroke stroke = pull(6);
    stroke.path = {stroke.path[begin], stroke.path[begin + 1], stroke.path[begin + 2]};
    return SessionStroke{stroke};
  };
  SessionStroke named{pull(2, -1)};
  named.name = "ear";
  SessionStroke also_named{growing("rotate", 2)[0]};
  also_named.name = "ear";
  const std::vector<std::vector<SessionStroke>> gestures{
      {continued(0)}, {continued(2)}, {{pull(2, 0.5)}, {growing("rotate", 3)[0]}}, {named}, {also_named}};
  Workbench bench(mesh);
  Lines journal;
  for (const std::vector<SessionStroke>& gesture : gestures) {
    for (std::size_t n = 1; n <= gesture.size(); ++n) {
      journal.follow(bench.set_live({gesture.begin(), gesture.begin() + static_cast<std::ptrdiff_t>(n)}).lines);
    }
    journal.follow(bench.finish().lines);
  }
  Session session;
  session.strokes = bench.strokes();
  Session recovered;
  recovered.strokes = journal.strokes;
  for (const Session& from : {session, recovered}) {
    Workbench again(mesh);
    ASSERT_TRUE(again.append(parse_session(serialize_session(from), "again").strokes).is_done());
    ASSERT_EQ(again.done().size(), gestures.size());
    for (std::size_t i = 0; i < gestures.size(); ++i) EXPECT_EQ(again.done()[i]->strokes.size(), gestures[i].size());
    EXPECT_TRUE(again.state().positions.copy() == bench.state().positions.copy());
  }
  // After an undo and a removal the marks are those of the entries that are left.
  bench.edit(0, {});
  session.strokes = bench.strokes();
  EXPECT_EQ(session.strokes[0].new_entry, std::nullopt);
  Workbench shorter(mesh);
  ASSERT_TRUE(shorter.append(session.strokes).is_done());
  EXPECT_EQ(shorter.done().size(), gestures.size() - 1);
}

// A pull on the middle of a face that no vertex follows, on a fine mesh, with a mask before it, and remeshed.
TEST(Workbench, SaysHowMuchOfTheMotionTheFacesMiss) {
  const auto missed = [](std::size_t vertices, bool remeshes, bool is_masked = false) {
    Workbench bench(make_shape(ShapeKind::sphere, vertices));
    EXPECT_EQ(bench.missed_motion(), 0) << "no entry";
    const Mesh& mesh = *bench.base().mesh;
    Vec3d middle;
    for (const std::uint32_t v : mesh.face(0)) middle += mesh.positions[v] / 3.0;
    if (is_masked) {
      MaskStroke mask;
      mask.points = mesh.positions;
      mask.width = 0.5;
      EXPECT_TRUE(bench.append(session_strokes({mask})).is_done());
    }
    std::vector<SessionStroke> strokes = session_strokes({ImplicitStroke{{middle, middle * 1.2}, 0.05, 0.2}});
    if (remeshes) strokes.front().remesh.emplace();
    EXPECT_TRUE(bench.append(strokes).is_done());
    const ShapeState now = bench.state();
    const double result = bench.missed_motion();
    EXPECT_TRUE(bench.state().is_same(now));
    EXPECT_TRUE(bench.undo().is_done());
    EXPECT_EQ(bench.missed_motion(), 0) << "no entry";
    return result;
  };
  EXPECT_GT(missed(42, false), 0.8);
  EXPECT_LT(missed(40962, false), 0.02);
  EXPECT_GT(missed(642, false), 0.02);
  EXPECT_EQ(missed(642, false, true), 0) << "the mask holds all";
  EXPECT_EQ(missed(42, true), 0);
}

}  // namespace
}  // namespace knead::workbench_test
