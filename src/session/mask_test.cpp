// Masks in sessions: replayed, resolved, taken back, undone, and kept in a journal.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "knead/certify.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"
#include "support/journal_work.h"

namespace knead::mask_test {
namespace {

Mesh ball() { return make_shape(ShapeKind::sphere, 2562); }

Session session_of(const std::vector<Stroke>& strokes) {
  Session session;
  session.name = "s.knead";
  for (const Stroke& stroke : strokes) session.strokes.push_back({stroke, session.strokes.size() + 2});
  return session;
}

// The vertices with x < 0 as ranges.
MaskStroke half(const Mesh& mesh, double width = 0.3) {
  MaskStroke stroke;
  stroke.width = width;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.positions[v].x >= 0) continue;
    if (!stroke.vertices.empty() && stroke.vertices.back().last + 1 == v) {
      ++stroke.vertices.back().last;
    } else {
      stroke.vertices.push_back({v, v});
    }
  }
  return stroke;
}

const ImplicitStroke kPull{{{0.2, 1, 0}, {0.2, 1.3, 0}, {0.1, 1.5, 0.1}}, 0.2, 0.8};

std::vector<Vec3d> result_of(const Mesh& mesh, const Session& session, const ReplayOptions& options = {}) {
  const ReplayResult result = replay(mesh, session, options);
  EXPECT_EQ(result.status, AdvectStatus::done);
  return result.shape.positions();
}

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

TEST(SessionMask, MaskedVerticesKeepTheirBitsUnderEveryStroke) {
  const Mesh mesh = ball();
  PaintStroke paint;
  paint.outer = 0.4;
  paint.depth = -0.05;
  paint.path = {{-0.3, 0.95, 0}, {0.3, 0.95, 0.1}};
  const Session session = session_of({half(mesh), kPull, paint, RotateStroke{{0, 0, 1}, {0, 0, 1}, 40, 0.2, 0.7},
                                      BendStroke{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 20, BendWidth{1}}});
  const ReplayResult result = replay(mesh, session);
  ASSERT_EQ(result.status, AdvectStatus::done);
  const std::vector<Vec3d>& after = result.shape.positions();
  std::size_t moved = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.positions[v].x < 0) {
      for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(bits(after[v][i]), bits(mesh.positions[v][i])) << v;
    } else if (norm(after[v] - mesh.positions[v]) > 0.05) {
      ++moved;
    }
  }
  EXPECT_GT(moved, 300u);
  // Of sampling: without the mask the volume of this ball changes by as much.
  EXPECT_NEAR(measure_volume_and_area(mesh, after).volume / measure(mesh).volume, 1, 0.01);
  EXPECT_EQ(result.strokes, 5u);
}

TEST(SessionMask, RemeshingLeavesMaskedVerticesAndTheFacesAmongThemAsTheyAre) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 642);
  MaskStroke mask;
  mask.width = 0.4;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (norm(mesh.positions[v] - Vec3d{0, 1, 0}) < 0.3) mask.vertices.push_back({v, v});
  }
  ASSERT_GT(mask.vertices.size(), 10u);
  const auto is_masked = [&](const Vec3d& p) { return norm(p - Vec3d{0, 1, 0}) < 0.3; };
  Session session = session_of({mask, kPull});
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.remesh.settings->max_edge = 0.12;
  const ReplayResult result = replay(mesh, session, options);
  ASSERT_EQ(result.status, AdvectStatus::done);
  const Mesh after = result.shape.to_mesh();
  EXPECT_GT(after.vertex_count(), mesh.vertex_count());
  const auto faces_among = [&](const Mesh& of) {
    std::vector<std::array<double, 9>> faces;
    for (std::size_t f = 0; f < of.face_count(); ++f) {
      std::array<double, 9> places{};
      bool all = true;
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3d& p = of.positions[of.face(f)[c]];
        all = all && is_masked(p);
        for (std::size_t i = 0; i < 3; ++i) places[3 * c + i] = p[i];
      }
      if (all) faces.push_back(places);
    }
    std::sort(faces.begin(), faces.end());
    return faces;
  };
  const auto kept = faces_among(after);
  const auto faces = faces_among(mesh);
  EXPECT_GT(faces.size(), 5u);
  EXPECT_TRUE(std::includes(kept.begin(), kept.end(), faces.begin(), faces.end()));
  EXPECT_TRUE(result.shape.provenance()->counts.complete);
  EXPECT_EQ(count_flipped(after, after.positions, after.positions), 0u);
}

// Followed as a whole, thousands of triangles cross after this pull.
TEST(SessionMask, APullFarBesideANarrowBorderIsFollowedInParts) {
  const Mesh mesh = ball();
  const ImplicitStroke pull{{{0.05, 0, 1}, {0.35, 0, 1.5}}, 0.15, 0.5};
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.must_follow = true;
  const ReplayResult result = replay(mesh, session_of({half(mesh, 0.1), pull}), options);
  ASSERT_EQ(result.status, AdvectStatus::done);
  const Mesh after = result.shape.to_mesh();
  EXPECT_EQ(result.shape.provenance()->counts.crossings, 0u);
  EXPECT_GT(after.vertex_count(), mesh.vertex_count());
  EXPECT_LT(after.vertex_count(), 5 * mesh.vertex_count());
  EXPECT_NEAR(measure(after).volume / measure(mesh).volume, 1, 1e-8);
  const std::vector<std::uint32_t>& source = result.shape.provenance()->vertex_source;
  const auto held = std::count_if(mesh.positions.begin(), mesh.positions.end(), [](const Vec3d& p) { return p.x < 0; });
  std::ptrdiff_t kept = 0;
  for (std::size_t v = 0; v < source.size(); ++v) {
    if (source[v] != kNewVertex && mesh.positions[source[v]].x < 0) {
      kept += after.positions[v] == mesh.positions[source[v]] ? 1 : 0;
    }
  }
  EXPECT_EQ(kept, held);
}

TEST(SessionMask, ARefusalBesideANarrowBorderNamesAWidthThatWillDo) {
  const Mesh mesh = ball();
  const ImplicitStroke pull{{{0.05, 0, 1}, {0.35, 0, 1.5}}, 0.15, 0.5};
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.remesh.settings->max_vertices = 4000;
  double width = 0;
  try {
    replay(mesh, session_of({half(mesh, 0.02), pull}), options);
    ADD_FAILURE() << "not refused";
  } catch (const RemeshLimit& limit) {
    const std::string text = limit.what();
    const std::string words = "make the mask's \"width\" ";
    ASSERT_NE(text.find(words), std::string::npos) << text;
    width = std::stod(text.substr(text.find(words) + words.size()));
  }
  EXPECT_NEAR(width, 0.3, 0.02);  // half of the way of the vertices, 0.58
  options.remesh.settings->max_vertices.reset();
  EXPECT_EQ(replay(mesh, session_of({half(mesh, width), pull}), options).status, AdvectStatus::done);
}

TEST(SessionMask, ResolvedItNamesNoVertexAndGivesTheSameBits) {
  const Mesh mesh = ball();
  MaskStroke soft = half(mesh);
  for (std::size_t i = 0; i < soft.vertices.size(); ++i) soft.values.push_back(i % 4 == 0 ? 0.6 : 1);
  const Session session = session_of({soft, kPull});
  const ReplayResult result = replay(mesh, session);
  Session resolved = session;
  resolved.strokes = result.resolved;
  const auto& mask = std::get<MaskStroke>(resolved.strokes.at(0).stroke);
  EXPECT_TRUE(mask.vertices.empty());
  EXPECT_FALSE(mask.points.empty());
  EXPECT_EQ(result_of(mesh, parse_session(serialize_session(resolved), "r.knead")), result.shape.positions());
  ReplayOptions back;
  back.part.direction = Direction::backwards;
  Mesh deformed = mesh;
  deformed.positions = result.shape.positions();
  const std::vector<Vec3d> restored = result_of(deformed, resolved, back);
  double worst = 0;
  for (std::size_t v = 0; v < restored.size(); ++v) worst = std::max(worst, norm(restored[v] - mesh.positions[v]));
  EXPECT_LT(worst, 1e-3);  // 1e-5 of the size there and back, magnified by the flow
  EXPECT_THROW(replay(deformed, session, back), InvalidInput);  // by vertices, of the shape before
}

TEST(SessionMask, HoldsUntilTheNextOne) {
  const Mesh mesh = ball();
  const std::vector<Vec3d> without = result_of(mesh, session_of({kPull}));
  EXPECT_EQ(result_of(mesh, session_of({half(mesh), MaskStroke{}, kPull})), without);
  EXPECT_NE(result_of(mesh, session_of({half(mesh), kPull})), without);
  // A mask that no stroke reaches changes no bit.
  MaskStroke far;
  far.points = {{0, -1, 0}};
  far.width = 0.2;
  EXPECT_EQ(result_of(mesh, session_of({far, kPull})), without);
}

TEST(SessionMask, TheReferenceSurfaceIsMaskedToo) {
  const Mesh mesh = ball();
  PaintStroke paint;
  paint.outer = 0.4;
  paint.depth = 0.05;
  paint.path = {{0.1, 1, 0}, {0.4, 0.9, 0.1}};
  const Session session = session_of({half(mesh), kPull, paint});
  ReplayOptions precise;
  precise.motion.precision = Precision::float64;
  const ReplayResult standard = replay(mesh, session);
  const ReplayResult other = replay(mesh, session, precise);
  EXPECT_EQ(other.resolved, standard.resolved);
  double worst = 0;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    worst = std::max(worst, norm(other.shape.positions()[v] - standard.shape.positions()[v]));
  }
  EXPECT_GT(worst, 0);
  EXPECT_LT(worst, 1e-3);
}

TEST(SessionMask, FramesAreReplaysUntilThen) {
  const Mesh mesh = ball();
  const Session session = session_of({half(mesh), kPull});
  ReplayOptions options;
  std::vector<std::vector<Vec3d>> frames;
  options.frames = {5, Ease::linear, 0, false,
                    [&](const ReplayFrame& frame) { frames.push_back(frame.shape.positions()); }};
  const std::vector<Vec3d> end = result_of(mesh, session, options);
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(frames.front(), mesh.positions);
  EXPECT_EQ(frames[2], mesh.positions);  // the mask alone
  EXPECT_EQ(frames.back(), end);
  ReplayOptions until;
  until.part.until = 1.5;
  EXPECT_EQ(frames[3], result_of(mesh, session, until));
}

TEST(SessionMask, IsPartOfTheCertificate) {
  const Mesh mesh = ball();
  ReplayOptions options;
  CertificateBuilder builder(mesh, options);
  options.on_stroke = [&](const AppliedStroke& stroke) { builder.add(stroke); };
  const ReplayResult result = replay(mesh, session_of({half(mesh), kPull}), options);
  const Certificate certificate = builder.finish(result, true);
  EXPECT_EQ(certificate.crossings_after, 0u);
  EXPECT_EQ(certificate.motion_outside, 0);
}

TEST(SessionMask, NamesNoVerticesAfterRemeshing) {
  const Mesh mesh = ball();
  Session session = session_of({kPull, half(mesh)});
  session.strokes[0].remesh = RemeshSettings{};
  try {
    replay(mesh, session);
    FAIL() << "was not refused";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("s.knead:3: \"vertices\" names vertices"), std::string::npos)
        << error.what();
  }
}

TEST(SessionMask, RefusesVerticesThatTheShapeLacks) {
  MaskStroke mask;
  mask.vertices = {{0, 2562}};
  mask.width = 0.1;
  EXPECT_THROW(replay(ball(), session_of({mask})), InvalidInput);
  mask.vertices = {{0, 2561}};
  mask.width = 1e-5;  // too small for the extent
  EXPECT_THROW(replay(ball(), session_of({mask})), InvalidInput);
}

TEST(SessionMask, WarnsOfFastFlowAlongItsBorder) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 10242);
  MaskStroke ring;  // thin, all round the middle of the tool
  ring.width = 0.05;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const double height = mesh.positions[v].y;
    if (height > 0.6 && height < 0.65) ring.vertices.push_back({v, v});
  }
  const ReplayResult result = replay(mesh, session_of({ring, ImplicitStroke{{{0, 1, 0}, {0.3, 1, 0}}, 0.3, 1.2}}));
  ASSERT_GE(result.warnings.size(), 1u);
  EXPECT_NE(result.warnings[0].find("s.knead:3: the flow along the mask's border is up to"), std::string::npos)
      << result.warnings[0];
  for (const std::string& warning : replay(mesh, session_of({half(mesh), kPull})).warnings) {
    EXPECT_EQ(warning.find("along the mask's border"), std::string::npos) << warning;
  }
}

TEST(SessionMask, ARelaxLeavesMaskedVertices) {
  const Mesh mesh = ball();
  const RelaxStroke relax{{{0, 1, 0}}, 0.8};
  const std::vector<Vec3d> after = result_of(mesh, session_of({half(mesh), relax}));
  bool moves = false;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.positions[v].x < 0) {
      EXPECT_EQ(after[v], mesh.positions[v]);
    }
    moves = moves || after[v] != mesh.positions[v];
  }
  EXPECT_TRUE(moves);
}

// A drag in pieces, undone and redone, has the bits of a replay.
TEST(SessionMask, AnEditorsShapeIsTheReplayedOne) {
  const Mesh mesh = ball();
  Workbench bench(mesh);
  const auto expect_as_replayed = [&] {
    Session session;
    session.strokes = bench.strokes();
    EXPECT_TRUE(bench.state().positions.copy() == result_of(mesh, session));
  };
  ASSERT_TRUE(bench.set_live({{half(mesh)}}).is_done());
  ASSERT_TRUE(bench.finish().is_done());
  ASSERT_EQ(bench.done().size(), 1u);
  EXPECT_FALSE(bench.state().mask.is_empty());
  ImplicitStroke growing = kPull;
  growing.path.resize(2);
  ASSERT_TRUE(bench.set_live({{growing}}).is_done());
  ASSERT_TRUE(bench.set_live({{kPull}}).is_done());
  expect_as_replayed();
  ASSERT_TRUE(bench.finish().is_done());
  const std::vector<Vec3d> masked = bench.state().positions.copy();
  ASSERT_TRUE(bench.undo().is_done());
  EXPECT_FALSE(bench.state().mask.is_empty());
  ASSERT_TRUE(bench.undo().is_done());
  EXPECT_TRUE(bench.state().mask.is_empty());
  ASSERT_TRUE(bench.set_live({{kPull}}).is_done());
  expect_as_replayed();
  EXPECT_FALSE(bench.state().positions.copy() == masked);
  ASSERT_TRUE(bench.undo().is_done());
  ASSERT_TRUE(bench.redo().is_done());
  ASSERT_TRUE(bench.redo().is_done());
  EXPECT_TRUE(bench.state().positions.copy() == masked);
  ASSERT_TRUE(bench.edit(0, {}).is_done());  // without the mask
  expect_as_replayed();
  EXPECT_TRUE(bench.state().mask.is_empty());
}

TEST(SessionMask, AJournalKeepsIt) {
  const test::Scratch scratch("mask_journal");
  ShapeFile shape = test::sphere();
  const std::vector<SessionStroke> strokes{{half(shape.mesh)}, {kPull}, {MaskStroke{}}};
  std::filesystem::path folder;
  {
    Journal journal = Journal::create(scratch.path(), shape, "masked");
    journal.append(strokes);
    journal.undo(1);
    folder = journal.folder();
  }
  const RecoveredWork work = recover_journal(folder);
  ASSERT_EQ(work.session.strokes.size(), 2u);
  EXPECT_EQ(work.session.strokes[0].stroke, strokes[0].stroke);
  EXPECT_EQ(work.session.strokes[1].stroke, strokes[1].stroke);
}

}  // namespace
}  // namespace knead::mask_test
