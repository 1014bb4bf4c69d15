// Replays in which the mesh follows the strokes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "knead/math/box.h"
#include "knead/math/error.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/shapes.h"
#include "knead/mesh/surface_tree.h"
#include "knead/session/replay.h"

namespace knead {
namespace {

Session session_of(const std::vector<Stroke>& strokes, const std::optional<RemeshSettings>& remesh = {}) {
  Session session;
  session.name = "s.knead";
  for (const Stroke& stroke : strokes) {
    SessionStroke& added = session.strokes.emplace_back();
    added.stroke = stroke;
    added.line = session.strokes.size() + 1;
    added.remesh = remesh;
  }
  return session;
}

Mesh ball() { return make_shape(ShapeKind::sphere, 642); }

// The sphere of radius 1 pulled out, then turned.
const std::vector<Stroke> kPulledAndTurned{ImplicitStroke{{{1, 0, 0}, {1.5, 0, 0}, {1.8, 0.2, 0}}, 0.2, 0.7},
                                           RotateStroke{{0, 1, 0}, {0, 1, 0}, 60, 0.2, 0.8}};

PaintStroke groove() {
  PaintStroke stroke;
  stroke.outer = 0.3;
  stroke.depth = 0.05;
  stroke.path = {{0, 1.4, -0.1}, {0, 1.4, 0.1}};
  return stroke;
}

ReplayOptions remeshing(const RemeshSettings& settings = {}) {
  ReplayOptions options;
  options.remesh = settings;
  return options;
}

std::string refusal(const Mesh& mesh, const Session& session, const ReplayOptions& options = {}) {
  try {
    replay(mesh, session, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "nothing";
}

void expect_same(const ReplayResult& a, const ReplayResult& b) {
  ASSERT_EQ(a.mesh.has_value(), b.mesh.has_value());
  EXPECT_TRUE(a.positions == b.positions);
  EXPECT_TRUE(a.face_source == b.face_source);
  EXPECT_TRUE(a.vertex_source == b.vertex_source);
  EXPECT_TRUE(a.steps == b.steps);
  if (!a.mesh) return;
  EXPECT_TRUE(a.mesh->positions == a.positions);
  EXPECT_TRUE(a.mesh->face_begin == b.mesh->face_begin);
  EXPECT_TRUE(a.mesh->corner_vertex == b.mesh->corner_vertex);
  EXPECT_TRUE(a.touched == b.touched);
}

TEST(ReplayRemeshed, WithoutSettingsNothingIsRemeshed) {
  const ReplayResult result = replay(ball(), session_of(kPulledAndTurned));
  EXPECT_FALSE(result.mesh);
  EXPECT_TRUE(result.vertex_source.empty());
}

// Each source is composed over the strokes: what is named is of the input.
TEST(ReplayRemeshed, SourcesNameFacesAndVerticesOfTheInput) {
  const Mesh mesh = ball();
  const ReplayResult result = replay(mesh, session_of(kPulledAndTurned, RemeshSettings{}));
  ASSERT_TRUE(result.mesh);
  const Mesh& after = *result.mesh;
  EXPECT_GT(after.vertex_count(), mesh.vertex_count());
  EXPECT_EQ(result.positions, after.positions);
  ASSERT_EQ(result.face_source.size(), after.face_count());
  ASSERT_EQ(result.vertex_source.size(), after.vertex_count());
  ASSERT_EQ(result.touched.size(), after.vertex_count());
  ASSERT_EQ(result.steps.size(), after.vertex_count());
  std::size_t untouched = 0;
  for (std::size_t i = 0; i < after.vertex_count(); ++i) {
    if (result.vertex_source[i] == kNewVertex) {
      EXPECT_TRUE(result.touched[i]);
      continue;
    }
    ASSERT_LT(result.vertex_source[i], mesh.vertex_count());
    if (result.touched[i]) continue;
    EXPECT_EQ(after.positions[i], mesh.positions[result.vertex_source[i]]);
    ++untouched;
  }
  EXPECT_GT(untouched, mesh.vertex_count() / 4);
  for (const std::uint32_t face : result.face_source) ASSERT_LT(face, mesh.face_count());
  EXPECT_EQ(measure(after).euler, 2);
  EXPECT_EQ(result.strokes, 2u);
  EXPECT_EQ(result.segments, 3u);
  EXPECT_GT(result.remesh.splits, 0u);
}

TEST(ReplayRemeshed, DoesNotDependOnThreads) {
  ReplayOptions one = remeshing();
  one.threads = 1;
  ReplayOptions two = remeshing();
  two.threads = 2;
  const Session session = session_of(kPulledAndTurned);
  expect_same(replay(ball(), session, one), replay(ball(), session, two));
}

TEST(ReplayRemeshed, AStrokesOwnSettingsWin) {
  RemeshSettings fine;
  fine.max_edge = 0.05;
  const ReplayResult own = replay(ball(), session_of(kPulledAndTurned, fine));
  expect_same(replay(ball(), session_of(kPulledAndTurned, fine), remeshing()), own);
  expect_same(replay(ball(), session_of(kPulledAndTurned), remeshing(fine)), own);
  EXPECT_GT(own.positions.size(), replay(ball(), session_of(kPulledAndTurned), remeshing()).positions.size());
}

// Strokes without settings move the vertices that the others have left.
TEST(ReplayRemeshed, OnlyStrokesWithSettingsChangeTheFaces) {
  Session session = session_of(kPulledAndTurned, RemeshSettings{});
  session.strokes[1].remesh.reset();
  ReplayOptions first;
  first.until = 1;
  const ReplayResult one = replay(ball(), session, first);
  const ReplayResult both = replay(ball(), session);
  ASSERT_TRUE(one.mesh && both.mesh);
  EXPECT_TRUE(one.mesh->corner_vertex == both.mesh->corner_vertex);
  const ReplayResult turned = replay(*one.mesh, session_of({kPulledAndTurned[1]}));
  double worst = 0;
  for (std::size_t i = 0; i < both.positions.size(); ++i) {
    worst = std::max(worst, norm(both.positions[i] - turned.positions[i]));
  }
  EXPECT_LT(worst, 1e-4);  // the tolerance is of another box
  EXPECT_GT(worst + norm(both.positions[0] - one.positions[0]), 0);
}

TEST(ReplayRemeshed, EveryFrameIsWhatUntilThatMomentGives) {
  const Session session = session_of(kPulledAndTurned, RemeshSettings{});
  for (const int frames : {1, 7}) {
    ReplayOptions options;
    options.frames = frames;
    std::vector<Mesh> delivered;
    options.on_frame = [&](const ReplayFrame& frame) {
      EXPECT_EQ(frame.index, static_cast<int>(delivered.size()));
      ASSERT_NE(frame.mesh, nullptr);
      EXPECT_EQ(frame.face_source.size(), frame.mesh->face_count());
      delivered.push_back(*frame.mesh);
    };
    Progress progress;
    options.progress = &progress;
    const ReplayResult result = replay(ball(), session, options);
    EXPECT_EQ(progress.done, total_work(ball(), session, options));
    ASSERT_EQ(delivered.size(), static_cast<std::size_t>(frames));
    EXPECT_TRUE(delivered.back().positions == result.positions);
    for (int k = 0; k + 1 < frames; ++k) {
      ReplayOptions until;
      until.until = 2.0 * k / (frames - 1);
      const ReplayResult expected = replay(ball(), session, until);
      EXPECT_TRUE(delivered[k].positions == expected.positions) << k;
      EXPECT_TRUE(delivered[k].corner_vertex == (expected.mesh ? *expected.mesh : ball()).corner_vertex) << k;
    }
  }
}

// Borders between labels hold vertices where they would else be moved along the surface.
TEST(ReplayRemeshed, KeepsLabelledFacesApart) {
  const Mesh mesh = ball();
  std::vector<std::uint32_t> labels(mesh.face_count());
  for (std::size_t f = 0; f < labels.size(); ++f) labels[f] = mesh.positions[mesh.face(f)[0]].y > 0.1 ? 1 : 0;
  ReplayOptions options = remeshing();
  options.face_labels = labels;
  const Session session = session_of(kPulledAndTurned);
  const ReplayResult labelled = replay(mesh, session, options);
  const ReplayResult plain = replay(mesh, session, remeshing());
  ASSERT_TRUE(labelled.mesh && plain.mesh);
  EXPECT_FALSE(labelled.positions == plain.positions);
  labels.pop_back();
  options.face_labels = labels;
  EXPECT_EQ(refusal(mesh, session, options), "give a label for each face");
}

TEST(ReplayRemeshed, IsCancelled) {
  Progress progress;
  progress.cancel = true;
  ReplayOptions options = remeshing();
  options.progress = &progress;
  const ReplayResult result = replay(ball(), session_of(kPulledAndTurned), options);
  EXPECT_EQ(result.status, AdvectStatus::cancelled);
  EXPECT_FALSE(result.mesh);
}

// The groove lies where the remeshed surface is when the stroke begins, and means the same at every accuracy.
TEST(ReplayRemeshed, StrokesReadTheRemeshedSurface) {
  const Stroke lift = ImplicitStroke{{{0, 1, 0}, {0, 1.4, 0}}, 0.2, 0.7};
  const Session session = session_of({lift, groove()}, RemeshSettings{});
  const ReplayResult result = replay(ball(), session);
  ASSERT_EQ(result.resolved.size(), 2u);
  ReplayOptions first;
  first.until = 1;
  const ReplayResult lifted = replay(ball(), session, first);
  ASSERT_TRUE(lifted.mesh);
  const SurfaceTree tree(triangulate(*lifted.mesh), lifted.positions);
  const auto& painted = std::get<PaintStroke>(result.resolved[1].stroke);
  ASSERT_FALSE(painted.samples.empty());
  EXPECT_LT(tree.closest(painted.samples.front().point)->distance, 1e-9);
  EXPECT_GT(painted.samples.front().point.y, 1.2);
  EXPECT_EQ(result.resolved[1].remesh, RemeshSettings{});

  ReplayOptions accurate;
  accurate.precision = Precision::float64;
  accurate.tolerance = 1e-8;
  accurate.single_precision = false;
  Progress progress;
  accurate.progress = &progress;
  const ReplayResult other = replay(ball(), session, accurate);
  EXPECT_EQ(other.resolved, result.resolved);
  EXPECT_EQ(progress.done, total_work(ball(), session, accurate));

  Session resolved = session;
  resolved.strokes = result.resolved;
  expect_same(replay(ball(), resolved), result);
}

TEST(ReplayRemeshed, RefusesNumbersOfVerticesThatHaveChanged) {
  HandlesStroke handles;
  handles.full_vertices = {0};
  handles.zero = {{0, 0, -2}};
  handles.motion = HandlesTranslation{{0, 0, 0.1}};
  EXPECT_EQ(refusal(ball(), session_of({handles}, RemeshSettings{})), "nothing");
  EXPECT_EQ(refusal(ball(), session_of({kPulledAndTurned[0], handles}, RemeshSettings{})),
            "s.knead:3: \"full_vertices\" names vertices whose numbers the remeshing of an earlier stroke has changed; "
            "name points instead, with \"full\"");
}

TEST(ReplayRemeshed, ChecksBarrelsOnTheRemeshedSurface) {
  TwistStroke twist{{0, 0, 0}, {1, 0, 0}, 20, -0.5, 0.5};
  twist.radius = 0.5;
  const std::string message = refusal(ball(), session_of({kPulledAndTurned[0], twist}, RemeshSettings{}));
  EXPECT_TRUE(message.starts_with("s.knead:3: ")) << message;
  EXPECT_NE(message.find("cross the cylinder"), std::string::npos) << message;
}

TEST(ReplayRemeshed, PointCloudsAndInversesKeepTheirPointsWithAWarning) {
  const Session session = session_of(kPulledAndTurned, RemeshSettings{});
  Mesh cloud;
  cloud.positions = ball().positions;
  const ReplayResult points = replay(cloud, session);
  EXPECT_FALSE(points.mesh);
  EXPECT_TRUE(points.positions == replay(ball(), session_of(kPulledAndTurned)).positions);
  ASSERT_EQ(points.warnings.size(), 1u);
  EXPECT_TRUE(points.warnings[0].starts_with("a point cloud has no mesh")) << points.warnings[0];
  ReplayOptions back = remeshing();
  back.inverse = true;
  const ReplayResult taken_back = replay(ball(), session, back);
  EXPECT_FALSE(taken_back.mesh);
  ASSERT_EQ(taken_back.warnings.size(), 1u);
  EXPECT_TRUE(taken_back.warnings[0].starts_with("backwards")) << taken_back.warnings[0];
}

TEST(ReplayRemeshed, RefusesSettingsOutOfRange) {
  RemeshSettings wrong;
  wrong.max_chord = 2;
  EXPECT_TRUE(refusal(ball(), session_of(kPulledAndTurned), remeshing(wrong)).starts_with("\"max_chord\""));
  EXPECT_TRUE(refusal(ball(), session_of(kPulledAndTurned, wrong)).starts_with("s.knead:2: \"max_chord\""));
}

// Strokes report themselves, with the shape before and after, with and without remeshing.
TEST(ReplayRemeshed, TellsOfEveryStroke) {
  for (const bool remeshed : {false, true}) {
    ReplayOptions options;
    if (remeshed) options.remesh = RemeshSettings{};
    options.until = 1.5;
    std::vector<Vec3d> last = ball().positions;
    std::vector<std::size_t> lines;
    options.on_stroke = [&](const AppliedStroke& stroke) {
      lines.push_back(stroke.line);
      EXPECT_TRUE(std::equal(last.begin(), last.end(), stroke.before.positions.begin()));
      last.assign(stroke.after.positions.begin(), stroke.after.positions.end());
      EXPECT_EQ(stroke.remeshed != nullptr, remeshed);
      if (stroke.remeshed == nullptr) return;
      EXPECT_EQ(stroke.remeshed->vertex_source.size(), stroke.after.positions.size());
      EXPECT_EQ(stroke.remeshed->face_source.size(), stroke.after.mesh.face_count());
    };
    const ReplayResult result = replay(ball(), session_of(kPulledAndTurned), options);
    EXPECT_EQ(lines, (std::vector<std::size_t>{2, 3}));
    EXPECT_TRUE(last == result.positions);
  }
}

}  // namespace
}  // namespace knead
