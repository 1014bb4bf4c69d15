// Replays in which the mesh follows the strokes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/replay.h"
#include "knead/vec.h"

namespace knead::replay_remeshed_test {
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
  options.remesh.settings = settings;
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
  ASSERT_EQ(a.shape.is_remeshed(), b.shape.is_remeshed());
  EXPECT_TRUE(a.shape.positions() == b.shape.positions());
  EXPECT_TRUE(a.shape.steps() == b.shape.steps());
  if (!a.shape.is_remeshed()) return;
  EXPECT_TRUE(a.shape.provenance()->face_source == b.shape.provenance()->face_source);
  EXPECT_TRUE(a.shape.provenance()->vertex_source == b.shape.provenance()->vertex_source);
  EXPECT_TRUE(a.shape.mesh().positions == a.shape.positions());
  EXPECT_TRUE(a.shape.mesh().face_begin == b.shape.mesh().face_begin);
  EXPECT_TRUE(a.shape.mesh().corner_vertex == b.shape.mesh().corner_vertex);
  EXPECT_TRUE(a.shape.touched() == b.shape.touched());
}

TEST(ReplayRemeshed, WithoutSettingsNothingIsRemeshed) {
  const ReplayResult result = replay(ball(), session_of(kPulledAndTurned));
  EXPECT_FALSE(result.shape.is_remeshed());
  EXPECT_EQ(result.shape.provenance(), nullptr);
}

// Each source is composed over the strokes: what is named is of the input.
TEST(ReplayRemeshed, SourcesNameFacesAndVerticesOfTheInput) {
  const Mesh mesh = ball();
  const ReplayResult result = replay(mesh, session_of(kPulledAndTurned, RemeshSettings{}));
  ASSERT_TRUE(result.shape.is_remeshed());
  const Mesh after = result.shape.to_mesh();
  const Provenance& provenance = *result.shape.provenance();
  const std::vector<bool> touched = result.shape.touched();
  EXPECT_GT(after.vertex_count(), mesh.vertex_count());
  EXPECT_EQ(result.shape.positions(), after.positions);
  ASSERT_EQ(provenance.face_source.size(), after.face_count());
  ASSERT_EQ(provenance.vertex_source.size(), after.vertex_count());
  ASSERT_EQ(touched.size(), after.vertex_count());
  ASSERT_EQ(result.shape.steps().size(), after.vertex_count());
  std::size_t untouched = 0;
  for (std::size_t i = 0; i < after.vertex_count(); ++i) {
    if (provenance.vertex_source[i] == kNewVertex) {
      EXPECT_TRUE(touched[i]);
      continue;
    }
    ASSERT_LT(provenance.vertex_source[i], mesh.vertex_count());
    if (touched[i]) continue;
    EXPECT_EQ(after.positions[i], mesh.positions[provenance.vertex_source[i]]);
    ++untouched;
  }
  EXPECT_GT(untouched, mesh.vertex_count() / 4);
  for (const std::uint32_t face : provenance.face_source) ASSERT_LT(face, mesh.face_count());
  EXPECT_EQ(measure(after).euler, 2);
  EXPECT_EQ(result.strokes, 2u);
  EXPECT_EQ(result.segments, 3u);
  EXPECT_GT(provenance.counts.splits, 0u);
}

TEST(ReplayRemeshed, DoesNotDependOnThreads) {
  ReplayOptions one = remeshing();
  one.motion.threads = 1;
  ReplayOptions two = remeshing();
  two.motion.threads = 2;
  const Session session = session_of(kPulledAndTurned);
  expect_same(replay(ball(), session, one), replay(ball(), session, two));
}

TEST(ReplayRemeshed, AStrokesOwnSettingsWin) {
  RemeshSettings fine;
  fine.max_edge = 0.05;
  const ReplayResult own = replay(ball(), session_of(kPulledAndTurned, fine));
  expect_same(replay(ball(), session_of(kPulledAndTurned, fine), remeshing()), own);
  expect_same(replay(ball(), session_of(kPulledAndTurned), remeshing(fine)), own);
  EXPECT_GT(own.shape.positions().size(),
            replay(ball(), session_of(kPulledAndTurned), remeshing()).shape.positions().size());
}

// Strokes without settings move the vertices that the others have left.
TEST(ReplayRemeshed, OnlyStrokesWithSettingsChangeTheFaces) {
  Session session = session_of(kPulledAndTurned, RemeshSettings{});
  session.strokes[1].remesh.reset();
  ReplayOptions first;
  first.part.until = 1;
  const ReplayResult one = replay(ball(), session, first);
  const ReplayResult both = replay(ball(), session);
  ASSERT_TRUE(one.shape.is_remeshed() && both.shape.is_remeshed());
  EXPECT_TRUE(one.shape.mesh().corner_vertex == both.shape.mesh().corner_vertex);
  const ReplayResult turned = replay(one.shape.to_mesh(), session_of({kPulledAndTurned[1]}));
  double worst = 0;
  for (std::size_t i = 0; i < both.shape.positions().size(); ++i) {
    worst = std::max(worst, norm(both.shape.positions()[i] - turned.shape.positions()[i]));
  }
  EXPECT_LT(worst, 1e-4);  // the tolerance is of another box
  EXPECT_GT(worst + norm(both.shape.positions()[0] - one.shape.positions()[0]), 0);
}

TEST(ReplayRemeshed, EveryFrameIsWhatUntilThatMomentGives) {
  const Session session = session_of(kPulledAndTurned, RemeshSettings{});
  for (const int frames : {1, 7}) {
    ReplayOptions options;
    options.frames.count = frames;
    std::vector<Mesh> delivered;
    options.frames.deliver = [&](const ReplayFrame& frame) {
      EXPECT_EQ(frame.index, static_cast<int>(delivered.size()));
      if (frame.shape.is_remeshed()) {
        EXPECT_EQ(frame.shape.provenance()->face_source.size(), frame.shape.mesh().face_count());
      }
      delivered.push_back(frame.shape.to_mesh());
    };
    Progress progress;
    options.progress = &progress;
    const ReplayResult result = replay(ball(), session, options);
    EXPECT_EQ(progress.done, Replay(borrow(ball()), session, options).work());
    ASSERT_EQ(delivered.size(), static_cast<std::size_t>(frames));
    EXPECT_TRUE(delivered.back().positions == result.shape.positions());
    for (int k = 0; k + 1 < frames; ++k) {
      ReplayOptions until;
      until.part.until = 2.0 * k / (frames - 1);
      const ReplayResult expected = replay(ball(), session, until);
      EXPECT_TRUE(delivered[k].positions == expected.shape.positions()) << k;
      EXPECT_TRUE(delivered[k].corner_vertex == expected.shape.mesh().corner_vertex) << k;
    }
  }
}

// The mesh is followed frame by frame from the beginning of the stroke, wherever the moments lie within its segments.
TEST(ReplayRemeshed, FramesWithinAPaintedStrokeAreWhatUntilThatMomentGives) {
  const Session session = session_of({ImplicitStroke{{{0, 1, 0}, {0, 1.4, 0}}, 0.2, 0.7}, groove()}, RemeshSettings{});
  ReplayOptions options;
  options.frames.count = 8;
  std::vector<Mesh> delivered;
  options.frames.deliver = [&](const ReplayFrame& frame) { delivered.push_back(frame.shape.to_mesh()); };
  const ReplayResult result = replay(ball(), session, options);
  ASSERT_EQ(delivered.size(), 8u);
  EXPECT_TRUE(delivered.back().positions == result.shape.positions());
  for (int k = 0; k < 7; ++k) {
    ReplayOptions until;
    until.part.until = 2.0 * k / 7;
    const ReplayResult expected = replay(ball(), session, until);
    EXPECT_TRUE(delivered[k].positions == expected.shape.positions()) << k;
    EXPECT_TRUE(delivered[k].corner_vertex == expected.shape.mesh().corner_vertex) << k;
  }
}

// A normal for each vertex, new ones included, that stands on the surface; the shape is the same without normals.
TEST(ReplayRemeshed, CarriesNormals) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 10242);
  const Session session = session_of(kPulledAndTurned);
  ReplayOptions options = remeshing();
  const ReplayResult plain = replay(mesh, session, options);
  options.normals = mesh.positions;
  for (Vec3d& n : options.normals) n = normalized(n);
  options.frames.count = 5;
  std::vector<Vec3d> last;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    last = frame.shape.normals();
    EXPECT_EQ(last.size(), frame.shape.positions().size());
  };
  const ReplayResult result = replay(mesh, session, options);
  EXPECT_TRUE(result.shape.positions() == plain.shape.positions());
  EXPECT_EQ(result.shape.mesh().attributes, plain.shape.mesh().attributes);
  const std::vector<Vec3d> normals = result.shape.normals();
  EXPECT_TRUE(normals == last);
  const std::vector<Vec3d> of_faces = vertex_normals(result.shape.to_mesh());
  const std::vector<bool> touched = result.shape.touched();
  const Provenance& provenance = *result.shape.provenance();
  ASSERT_EQ(normals.size(), of_faces.size());
  double worst = 1;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    EXPECT_NEAR(norm(normals[i]), 1, 1e-9);
    worst = std::min(worst, dot(normals[i], of_faces[i]));
    if (!touched[i]) {  // at the rim of a tool the points around a vertex may move where it does not
      EXPECT_LT(norm(normals[i] - options.normals[provenance.vertex_source[i]]), 1e-9);
    }
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_GT(worst, 0.8);
}

// Borders between labels hold vertices where they would else be moved along the surface.
TEST(ReplayRemeshed, KeepsLabelledFacesApart) {
  const Mesh mesh = ball();
  std::vector<std::uint32_t> labels(mesh.face_count());
  for (std::size_t f = 0; f < labels.size(); ++f) labels[f] = mesh.positions[mesh.face(f)[0]].y > 0.1 ? 1 : 0;
  ReplayOptions options = remeshing();
  options.remesh.face_labels = labels;
  const Session session = session_of(kPulledAndTurned);
  const ReplayResult labelled = replay(mesh, session, options);
  const ReplayResult plain = replay(mesh, session, remeshing());
  ASSERT_TRUE(labelled.shape.is_remeshed() && plain.shape.is_remeshed());
  EXPECT_FALSE(labelled.shape.positions() == plain.shape.positions());
  labels.pop_back();
  options.remesh.face_labels = labels;
  EXPECT_EQ(refusal(mesh, session, options), "give a label for each face");
}

TEST(ReplayRemeshed, IsCancelled) {
  Progress progress;
  progress.cancel = true;
  ReplayOptions options = remeshing();
  options.progress = &progress;
  const ReplayResult result = replay(ball(), session_of(kPulledAndTurned), options);
  EXPECT_EQ(result.status, AdvectStatus::cancelled);
  EXPECT_FALSE(result.shape.is_remeshed());
}

// The groove lies where the remeshed surface is when the stroke begins, and means the same at every accuracy.
TEST(ReplayRemeshed, StrokesReadTheRemeshedSurface) {
  const Stroke lift = ImplicitStroke{{{0, 1, 0}, {0, 1.4, 0}}, 0.2, 0.7};
  const Session session = session_of({lift, groove()}, RemeshSettings{});
  const ReplayResult result = replay(ball(), session);
  ASSERT_EQ(result.resolved.size(), 2u);
  ReplayOptions first;
  first.part.until = 1;
  const ReplayResult lifted = replay(ball(), session, first);
  ASSERT_TRUE(lifted.shape.is_remeshed());
  const SurfaceTree tree(triangulate(lifted.shape.to_mesh()), lifted.shape.positions());
  const auto& painted = std::get<PaintStroke>(result.resolved[1].stroke);
  ASSERT_FALSE(painted.samples.empty());
  EXPECT_LT(tree.closest(painted.samples.front().point)->distance, 1e-9);
  EXPECT_GT(painted.samples.front().point.y, 1.2);
  EXPECT_EQ(result.resolved[1].remesh, RemeshSettings{});

  ReplayOptions accurate;
  accurate.motion.precision = Precision::float64;
  accurate.motion.relative_tolerance = 1e-8;
  accurate.remesh.single_precision = false;
  Progress progress;
  accurate.progress = &progress;
  const ReplayResult other = replay(ball(), session, accurate);
  EXPECT_EQ(other.resolved, result.resolved);
  EXPECT_EQ(progress.done, Replay(borrow(ball()), session, accurate).work());

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
            "s.knead:3: \"full_vertices\" names vertices, but remeshing after an earlier stroke changed their numbers; "
            "name points instead, with \"full\"");
}

TEST(ReplayRemeshed, ChecksLimitCylindersOnTheRemeshedSurface) {
  TwistStroke twist{{0, 0, 0}, {1, 0, 0}, 20, -0.5, 0.5};
  twist.radius = 0.5;
  const std::string message = refusal(ball(), session_of({kPulledAndTurned[0], twist}, RemeshSettings{}));
  EXPECT_TRUE(message.starts_with("s.knead:3: ")) << message;
  EXPECT_NE(message.find("cross the limit cylinder"), std::string::npos) << message;
}

TEST(ReplayRemeshed, PointCloudsAndInversesKeepTheirPointsWithAWarning) {
  const Session session = session_of(kPulledAndTurned, RemeshSettings{});
  Mesh cloud;
  cloud.positions = ball().positions;
  const ReplayResult points = replay(cloud, session);
  EXPECT_FALSE(points.shape.is_remeshed());
  EXPECT_TRUE(points.shape.positions() == replay(ball(), session_of(kPulledAndTurned)).shape.positions());
  ASSERT_EQ(points.warnings.size(), 1u);
  EXPECT_TRUE(points.warnings[0].starts_with("a point cloud has no faces")) << points.warnings[0];
  ReplayOptions back = remeshing();
  back.part.direction = Direction::backwards;
  const ReplayResult restored = replay(ball(), session, back);
  EXPECT_FALSE(restored.shape.is_remeshed());
  ASSERT_EQ(restored.warnings.size(), 1u);
  EXPECT_TRUE(restored.warnings[0].starts_with("a session that is applied backwards")) << restored.warnings[0];
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
    if (remeshed) options.remesh.settings = RemeshSettings{};
    options.part.until = 1.5;
    std::vector<Vec3d> last = ball().positions;
    std::vector<std::size_t> lines;
    options.on_stroke = [&](const AppliedStroke& stroke) {
      lines.push_back(stroke.line);
      EXPECT_TRUE(std::equal(last.begin(), last.end(), stroke.before.positions().begin()));
      last.assign(stroke.after.positions().begin(), stroke.after.positions().end());
      EXPECT_EQ(stroke.remeshed != nullptr, remeshed);
      if (stroke.remeshed == nullptr) return;
      EXPECT_EQ(stroke.remeshed->vertex_source.size(), stroke.after.positions().size());
      EXPECT_EQ(stroke.remeshed->face_source.size(), stroke.after.mesh().face_count());
    };
    const ReplayResult result = replay(ball(), session_of(kPulledAndTurned), options);
    EXPECT_EQ(lines, (std::vector<std::size_t>{2, 3}));
    EXPECT_TRUE(last == result.shape.positions());
  }
}

// At once, triangles cross after this stroke. Halves of it are remeshed one after the other, and what is said of the
// result is said of the whole stroke.
TEST(ReplayRemeshed, AStrokeAfterWhichTrianglesCrossIsRemeshedInHalves) {
  const Mesh coarse = make_shape(ShapeKind::sphere, 162);
  const ImplicitStroke stroke{{{-0.244405, 0.397998, -0.884231}, {-0.762841, 1.34388, -0.475298}}, 0.473, 0.634};
  RemeshSettings settings;
  settings.max_chord = 0.004;
  ReplayOptions options = remeshing(settings);
  std::size_t segments = 0;
  std::optional<Remeshed> remeshed;
  options.on_stroke = [&](const AppliedStroke& applied) {
    segments = applied.flow.segments.size();
    remeshed = *applied.remeshed;
    DeformedShape at_once = applied.before;
    ASSERT_EQ(at_once.move(applied.flow), AdvectStatus::done);
    Deformation deformation;
    deformation.carry = [&](std::span<Vec3d> points) {
      advect(applied.flow, points, advect_options({}, at_once.reference_length()));
    };
    RemeshOptions remesh_options;
    remesh_options.targets = resolve(settings, coarse);
    EXPECT_GT(remesh(coarse, at_once.positions(), deformation, remesh_options).counts.crossings, 0U);
  };
  const ReplayResult result = replay(coarse, session_of({stroke}), options);
  ASSERT_EQ(result.status, AdvectStatus::done);
  EXPECT_EQ(segments, 1U);
  const Provenance& provenance = *result.shape.provenance();
  EXPECT_EQ(provenance.counts.crossings, 0U);
  const Measures measures = measure(result.shape.to_mesh());
  EXPECT_TRUE(measures.closed());
  EXPECT_EQ(measures.euler, 2);
  EXPECT_NEAR(measures.volume / measure(coarse).volume, 1, 1e-6);
  ASSERT_EQ(remeshed->vertex_source.size(), result.shape.positions().size());
  EXPECT_EQ(provenance.before_stroke, provenance.rest);  // the stroke is the first one
  EXPECT_GT(remeshed->face_source.size(), coarse.face_count());
  for (std::size_t f = 0; f < remeshed->face_source.size(); ++f) {  // each face lies near the one that it comes from
    Vec3d place{};
    Vec3d source{};
    for (const std::uint32_t v : result.shape.mesh().face(f)) place += provenance.rest[v] / 3;
    for (const std::uint32_t v : coarse.face(remeshed->face_source[f])) source += coarse.positions[v] / 3;
    ASSERT_LT(norm(place - source), 0.4) << f;
  }
}

// Two spheres, of radius 1 and 0.97, cross in curves. Pulls split the triangles there: more pairs lie along these
// curves.
TEST(ReplayRemeshed, CurvesInWhichTheShapeCrossedMayHaveMorePairs) {
  Mesh both = make_shape(ShapeKind::sphere, 642);
  const Mesh other = both;
  const auto first = static_cast<std::uint32_t>(both.vertex_count());
  for (const Vec3d& p : other.positions) both.positions.push_back(p * 0.97 + Vec3d{0.03, 0, 0});
  for (std::size_t f = 0; f < other.face_count(); ++f) {
    std::vector<std::uint32_t> face(other.face(f).begin(), other.face(f).end());
    for (std::uint32_t& v : face) v += first;
    both.add_face(face);
  }
  const auto pull = [](const Vec3d& from, const Vec3d& to) {
    ImplicitStroke stroke;
    stroke.path = {from, to};
    stroke.inner = 0.2;
    stroke.outer = 0.5;
    return stroke;
  };
  const Session session = session_of(
      {pull({-0.0443, -0.999, 0.1}, {-0.071, -1.598, 0.13}), pull({0.7508, 0.6606, 0.1}, {0.976, 1.0569, 0.16})});
  bool has_more = false;
  ReplayOptions options = remeshing();
  options.on_stroke = [&](const AppliedStroke& stroke) {
    const RemeshCounts& counts = stroke.remeshed->counts;
    has_more = has_more || counts.crossings > counts.crossings_before;
    EXPECT_LE(counts.curves, counts.curves_before);
  };
  EXPECT_NO_THROW(replay(both, session, options));
  EXPECT_TRUE(has_more);
}

// A sheet far from the origin: the new vertices of its refined faces cross where positions are rounded, also before it
// is deformed. That is no excuse for crossings afterwards.
TEST(ReplayRemeshed, RoundingOfNewVerticesExcusesNoCrossings) {
  Mesh sheet;
  const Vec3d middle{40.80713754679166, -87.8237346581092, -24.84732888};
  for (int i = 0; i < 28; ++i) {
    for (int j = 0; j < 14; ++j) {
      const double x = 2 * i / 27.0 - 1;
      const double y = 2 * j / 13.0 - 1;
      const double z = 0.09240831 * std::sin(4 * x - 3.20071708) + 0.17298226 * std::cos(3 * y) + 0.19766554 * x * y;
      sheet.positions.push_back(middle + Vec3d{x, y, z});
    }
  }
  for (std::uint32_t i = 0; i < 27; ++i) {
    for (std::uint32_t a = 14 * i; a < 14 * i + 13; ++a) {
      sheet.add_face(std::array{a, a + 14, a + 15});
      sheet.add_face(std::array{a, a + 15, a + 1});
    }
  }
  const Session session = parse_session(R"({"knead": 1}
{"tool": "handles", "full_vertices": [351, 294, 365, 308, 379, 322, 336, 350, 364, 378], "zero_vertices": [13, 27, 41, 55, 69, 12, 83, 26, 97, 40], "motion": {"rotate": [-0.309067846, 0.787860816, -0.532684147], "center": [40.8071375, -87.8237347, -24.8532562], "angle_deg": -16.3586489}, "exponent": 2}
)",
                                        "s.knead");
  const ReplayResult result = replay(sheet, session, remeshing());
  std::vector<Vec3d> written;
  for (const Vec3d& p : result.shape.positions()) {
    written.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  EXPECT_EQ(self_intersections(result.shape.triangles(), written).count, 0U);
}

// A thin box is pressed until floats do not tell its two sides apart: no remeshing can end that.
TEST(ReplayRemeshed, WhatCrossesWithoutRemedyIsRefusedUnlessItIsAllowed) {
  Mesh thin = make_shape(ShapeKind::box, shape_counts(ShapeKind::box).minimum);
  for (Vec3d& p : thin.positions) p = {0.01 * p.x, 0.01 * p.y, 1 + 1e-6 * p.z};
  const Session session = session_of(
      {StretchStroke{{0, 0, 1}, {0, 0, 1}, 0.8, 0.4, 0.8}, StretchStroke{{0, 0, 1}, {0, 0, 1}, 0.02, 0.4, 0.8}});
  ReplayOptions options = remeshing();
  const std::string text = refusal(thin, session, options);
  EXPECT_EQ(text.rfind("s.knead:3: ", 0), 0U) << text;
  EXPECT_NE(text.find("after this stroke, which remeshing cannot end"), std::string::npos) << text;
  EXPECT_THROW(replay(thin, session, options), RemeshLimit);
  options.frames.count = 5;
  int frames = 0;
  options.frames.deliver = [&](const ReplayFrame&) { ++frames; };
  EXPECT_THROW(replay(thin, session, options), RemeshLimit);
  EXPECT_LT(frames, 5);
  options.frames = {};
  options.may_cross = true;
  const ReplayResult kept = replay(thin, session, options);
  ASSERT_EQ(kept.status, AdvectStatus::done);
  EXPECT_GT(kept.shape.provenance()->counts.crossings, 0U);
  options.may_cross = false;
  options.remesh.single_precision = false;  // doubles tell them apart
  EXPECT_EQ(replay(thin, session, options).shape.provenance()->counts.crossings, 0U);
}

// Without a limit no triangles cross; without time they do, and the warning says where.
TEST(ReplayRemeshed, WhatStillCrossesWhenTheTimeIsOverIsNamed) {
  const Mesh coarse = make_shape(ShapeKind::sphere, 2562);
  const Session session = session_of({ImplicitStroke{{{0, 0, 1}, {0, 0.3, 1.9}, {1.5, 0.3, 1.9}}, 0.3, 0.9}});
  ReplayOptions options = remeshing();
  options.remesh.seconds = 1e-9;
  const ReplayResult result = replay(coarse, session, options);
  ASSERT_EQ(result.status, AdvectStatus::done);
  const RemeshCounts& counts = result.shape.provenance()->counts;
  EXPECT_TRUE(counts.out_of_time);
  ASSERT_GT(counts.crossings, 1U);
  ASSERT_GE(result.warnings.size(), 1U);
  EXPECT_EQ(result.warnings[0].rfind("s.knead:2: the mesh was not improved to the end, for want of time; " +
                                         std::to_string(counts.crossings) + " pairs of triangles still cross, near (",
                                     0),
            0U)
      << result.warnings[0];
  options.remesh.seconds = 1e5;
  expect_same(replay(coarse, session, options), replay(coarse, session, remeshing()));
  for (const double wrong : {0.0, -1.0, std::nan("")}) {
    options.remesh.seconds = wrong;
    EXPECT_NE(refusal(coarse, session, options).find("above 0"), std::string::npos) << wrong;
  }
}

}  // namespace
}  // namespace knead::replay_remeshed_test
