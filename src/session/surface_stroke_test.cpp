// Strokes that read the surface: what becomes of them when a session is replayed and resolved.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"
#include "support/dual.h"
#include "support/scratch.h"
#include "support/unwelded.h"

namespace knead::surface_stroke_test {
namespace {

// A folder for the tool's file, and sessions beside it.
class SurfaceStroke : public testing::Test {
 protected:
  SurfaceStroke() {
    Mesh ball = make_shape(ShapeKind::sphere, 400);
    for (Vec3d& p : ball.positions) p = p * 0.3;
    write_mesh(folder_ / "ball.ply", ball);
  }

  Session session_of(const std::string& lines) const {
    return parse_session("{\"knead\": 1}\n" + lines, (folder_ / "s.knead").string());
  }

  Session session(const std::string& kind) const { return session_of(lines_of(kind)); }

  // One stroke before and one after, so that the surface is read as it is then.
  static std::string lines_of(const std::string& kind) {
    const std::string pull = R"({"tool": "implicit", "inner": 0.2, "outer": 0.7, "path": [[0, 0, 1], [0, 0.2, 1.1]]})";
    const std::string turn =
        R"({"tool": "rotate", "center": [0, 0, 1], "axis": [0, 0, 1], "angle_deg": 20, "inner": 0.1, "outer": 0.6})";
    if (kind == "paint") {
      return pull + "\n" + R"({"tool": "paint", "outer": 0.4, "depth": 0.1, "path": [[0.5, 0, 1], [0, 0.2, 1.2]]})" +
             "\n" + turn + "\n";
    }
    if (kind == "handles") {
      return pull + "\n" +
             R"({"tool": "handles", "full_vertices": [0, 1, 2], "zero_vertices": [200, 201], )"
             R"("motion": {"rotate": [0, 1, 0], "center": [0, 0, 0], "angle_deg": 10}})" +
             "\n" + turn + "\n";
    }
    if (kind == "stamp" || kind == "slip") {
      return pull + "\n" + R"({"tool": "stamp", "mesh": "ball.ply", "outer": 0.5, "step": 0.05, )" +
             (kind == "slip" ? R"("contact": "slip", )" : "") +
             R"("path": [[1.4, 0, 0], [1.1, 0, 0], [1.1, 0.2, 0]]})" + "\n" + turn + "\n";
    }
    if (kind == "print") {
      return pull + "\n" +
             R"({"tool": "print", "file": "ball.ply", "point": [0, 0, 1.1], "height": 0.6, "depth": 0.1})" + "\n" +
             turn + "\n";
    }
    return pull + "\n" +
           R"({"tool": "twist", "center": [0, 0, 0.5], "axis": [0, 0, -1], "rate_deg": 20, "inner": -0.3, "outer": 0.2, )"
           R"("radius": "auto"})" +
           "\n";
  }

  test::Scratch scratch_{"surface_stroke"};
  const std::filesystem::path& folder_ = scratch_.path();
};

const std::vector<std::string> kKinds{"paint", "handles", "stamp", "slip", "print", "twist"};

Mesh shape() { return make_shape(ShapeKind::sphere, 1500); }

Session resolved_of(const Mesh& mesh, const Session& session, const ReplayOptions& options = {}) {
  Session resolved;
  resolved.strokes = replay(mesh, session, options).resolved;
  return parse_session(serialize_session(resolved), "resolved.knead");  // as it comes back from its file
}

TEST_F(SurfaceStroke, ResolvedReplaysToTheSameBits) {
  const Mesh mesh = shape();
  for (const std::string& kind : kKinds) {
    for (const Precision precision : {Precision::float32, Precision::float64}) {
      ReplayOptions options;
      options.motion.precision = precision;
      const ReplayResult result = replay(mesh, session(kind), options);
      ASSERT_EQ(result.status, AdvectStatus::done) << kind;
      const Session resolved = resolved_of(mesh, session(kind));  // whatever the precision
      const ReplayResult again = replay(mesh, resolved, options);
      EXPECT_TRUE(again.shape.positions() == result.shape.positions()) << kind;
      EXPECT_TRUE(again.shape.steps() == result.shape.steps()) << kind;
      EXPECT_EQ(again.shape.work().accepted_steps, result.shape.work().accepted_steps) << kind;
      EXPECT_EQ(again.segments, result.segments) << kind;
      EXPECT_EQ(again.resolved.size(), resolved.strokes.size()) << kind;
      EXPECT_EQ(result.strokes, session(kind).strokes.size()) << kind;
      for (const SessionStroke& stroke : resolved.strokes) EXPECT_FALSE(reads_surface(stroke.stroke)) << kind;
    }
  }
}

// To the tolerance of every segment, as magnified on the way, which for these strokes is little.
TEST_F(SurfaceStroke, ResolvedTakesTheShapeBack) {
  Mesh mesh = shape();
  const std::vector<Vec3d> before = mesh.positions;
  for (const std::string& kind : kKinds) {
    ReplayOptions options;
    options.motion.precision = Precision::float64;
    options.motion.relative_tolerance = 1e-8;
    mesh.positions = before;
    const Session resolved = resolved_of(mesh, session(kind), options);
    mesh.positions = replay(mesh, resolved, options).shape.positions();
    options.part.direction = Direction::backwards;
    const ReplayResult back = replay(mesh, resolved, options);
    ASSERT_EQ(back.shape.positions().size(), before.size()) << kind;
    double worst = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
      worst = std::max(worst, norm(back.shape.positions()[i] - before[i]));
    EXPECT_LT(worst, 2e-5) << kind;
  }
}

TEST_F(SurfaceStroke, ItselfIsNotTakenBackAndSaysHow) {
  ReplayOptions options;
  options.part.direction = Direction::backwards;
  for (const std::string& kind : kKinds) {
    try {
      replay(shape(), session(kind), options);
      FAIL() << kind;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("s.knead:3: this stroke reads the surface"), std::string::npos)
          << error.what();
    }
  }
}

TEST_F(SurfaceStroke, FramesAndPartsAreThoseOfItsSegments) {
  const Mesh mesh = shape();
  for (const std::string& kind : kKinds) {
    const Session resolved = resolved_of(mesh, session(kind));
    Flow flow;
    const std::size_t end = resolved.strokes.size() - (kind == "twist" ? 0 : 1);
    for (std::size_t i = 1; i < end; ++i) {
      for (const Segment& segment : flow_of(resolved.strokes[i].stroke).segments) flow.segments.push_back(segment);
    }
    std::vector<Vec3d> expected = mesh.positions;
    AdvectOptions advect_options;
    advect_options.tolerance = 1e-5 * bounding_box(mesh.positions).diagonal();
    advect(flow_of(resolved.strokes.front().stroke), expected, advect_options);
    advect(prefix(flow, (1.6 - 1) * static_cast<double>(flow.segments.size())), expected, advect_options);
    ReplayOptions options;
    options.part.until = 1.6;
    EXPECT_TRUE(replay(mesh, session(kind), options).shape.positions() == expected) << kind;

    options.part.until = std::nullopt;
    options.frames.count = static_cast<int>(5 * session(kind).strokes.size()) + 1;
    Progress progress;
    options.progress = &progress;
    std::vector<Vec3d> eighth;
    std::vector<Vec3d> last;
    options.frames.deliver = [&](const ReplayFrame& frame) {
      if (frame.index == 8) eighth.assign(frame.shape.positions().begin(), frame.shape.positions().end());
      last.assign(frame.shape.positions().begin(), frame.shape.positions().end());
    };
    const ReplayResult result = replay(mesh, session(kind), options);
    EXPECT_TRUE(eighth == expected) << kind;
    EXPECT_TRUE(last == result.shape.positions()) << kind;
    EXPECT_TRUE(result.shape.positions() == replay(mesh, session(kind)).shape.positions()) << kind;
    EXPECT_EQ(progress.done, Replay(borrow(mesh), session(kind), options).work()) << kind;
  }
}

TEST_F(SurfaceStroke, IsPlannedOnce) {
  const Mesh mesh = shape();
  const Session stamping = session("stamp");
  Progress progress;
  ReplayOptions options;
  options.progress = &progress;
  Replay planned(borrow(mesh), stamping, options);
  const std::uint64_t work = planned.work();
  std::filesystem::remove(folder_ / "ball.ply");  // which the plan has read
  EXPECT_EQ(planned.run().status, AdvectStatus::done);
  EXPECT_EQ(progress.total, work);
  EXPECT_EQ(progress.done, work);
}

TEST_F(SurfaceStroke, DoesNotDependOnThreads) {
  const Mesh mesh = shape();
  for (const std::string& kind : kKinds) {
    ReplayOptions one;
    one.motion.threads = 1;
    ReplayOptions two;
    two.motion.threads = 2;
    EXPECT_TRUE(replay(mesh, session(kind), one).shape.positions() ==
                replay(mesh, session(kind), two).shape.positions())
        << kind;
  }
}

TEST_F(SurfaceStroke, OfWhatTheSurfaceCannotTakeNameTheLine) {
  const auto error_of = [&](const std::string& line, const Mesh& mesh) -> std::string {
    try {
      replay(mesh, session_of(line + "\n"));
      return "no error";
    } catch (const InvalidInput& error) {
      return error.what();
    }
  };
  Mesh cloud;
  cloud.positions = shape().positions;
  const std::string paint = R"({"tool": "paint", "outer": 0.4, "depth": 0.1, "path": [[0, 0, 1]]})";
  EXPECT_NE(error_of(paint, cloud).find("s.knead:2: \"path\" needs a surface"), std::string::npos);
  const std::string vertices = R"({"tool": "handles", "full_vertices": [1], "zero_vertices": [99999], )"
                               R"("motion": {"translate": [1, 0, 0]}})";
  EXPECT_NE(error_of(vertices, shape()).find("s.knead:2: \"zero_vertices\" names vertex 99999"), std::string::npos);
  const std::string missing = R"({"tool": "stamp", "mesh": "nothing.ply", "path": [[0, 0, 0], [1, 0, 0]]})";
  EXPECT_NE(error_of(missing, shape()).find("s.knead:2: \"mesh\""), std::string::npos);
}

// The fields of what strokes on a surface become, regions of contacts among them. What rounding leaves of a divergence
// is relative to the Jacobian.
TEST_F(SurfaceStroke, FieldsAreDivergenceFree) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> offset(-0.3, 0.3);
  for (const std::string& kind : kKinds) {
    int tried = 0;
    for (const SessionStroke& stroke : resolved_of(shape(), session(kind)).strokes) {
      for (const Segment& segment : flow_of(stroke.stroke).segments) {
        if (!segment.grid.is_empty()) continue;  // a curl
        const Field& field = segment.fields.front();
        const Vec3d d{offset(random), offset(random), offset(random)};
        std::visit(
            [&](const auto& motion, const auto& region) {
              if constexpr (!std::is_same_v<std::decay_t<decltype(motion)>, CustomMotion> &&
                            !std::is_same_v<std::decay_t<decltype(region)>, CustomRegion>) {
                const auto v = velocity(motion, region, field.thresholds, test::variables(d), test::Dual(0.3));
                EXPECT_LT(std::abs(test::divergence(v)), 1e-11 * std::fmax(1, test::jacobian_size(v))) << kind;
                ++tried;
              }
            },
            field.motion, field.region);
      }
    }
    EXPECT_GT(tried, 1) << kind;
  }
}

// The vertices alone, without faces, go where those of the shape go.
TEST_F(SurfaceStroke, PointCloudsGoThroughEveryToolThatNeedsNoFaces) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 8000);
  Mesh cloud;
  cloud.positions = mesh.positions;
  for (
      const char* line : {
          R"({"tool": "implicit", "inner": 0.2, "outer": 0.7, "path": [[0, 0, 1], [0, 0.2, 1.1]]})",
          R"({"tool": "paint", "outer": 0.4, "depth": 0.1, "samples": [{"point": [0, 0, 1], "normal": [0, 0, 1]}]})",
          R"({"tool": "points", "points": [[0, 0, 1]], "outer": 0.5, "displacements": [[0, 0.1, 0.1]]})",
          R"({"tool": "handles", "full_vertices": [7], "zero_vertices": [8, 90], "motion": {"translate": [0.1, 0, 0]}})",
          R"({"tool": "rotate", "center": [0, 0, 1], "axis": [0, 1, 0], "angle_deg": 40, "inner": 0.1, "outer": 0.6})",
          R"({"tool": "stretch", "center": [0, 0, 1], "axis": [0, 1, 0], "factor": 1.5, "inner": 0.1, "outer": 0.6})",
          R"({"tool": "twist", "center": [0, 0, 0], "axis": [0, 1, 0], "rate_deg": 40, "inner": -1, "outer": 1})",
          R"({"tool": "bend", "center": [0, 0, 0], "axis": [0, 1, 0], "normal": [1, 0, 0], "angle_deg": 40, "width": 1})",
      }) {
    const std::vector<Vec3d> moved = replay(cloud, session_of(std::string(line) + "\n")).shape.positions();
    EXPECT_TRUE(moved != cloud.positions) << line;
    EXPECT_TRUE(moved == replay(mesh, session_of(std::string(line) + "\n")).shape.positions()) << line;
  }
}

// Of a cloud only the points themselves can be contacts; here they are denser than contacts need be.
TEST_F(SurfaceStroke, PointCloudsAreStamped) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 16000);
  Mesh cloud;
  cloud.positions = mesh.positions;
  const std::string line =
      R"({"tool": "stamp", "mesh": "ball.ply", "outer": 0.5, "step": 0.05, "path": [[1.4, 0, 0], [1.1, 0, 0]]})";
  const std::vector<Vec3d> moved = replay(cloud, session_of(line + "\n")).shape.positions();
  const std::vector<Vec3d> expected = replay(mesh, session_of(line + "\n")).shape.positions();
  double worst = 0;
  double farthest = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    worst = std::max(worst, norm(moved[i] - expected[i]));
    farthest = std::max(farthest, norm(expected[i] - mesh.positions[i]));
  }
  EXPECT_GT(farthest, 0.15);
  EXPECT_LT(worst, 0.1 * farthest);
}

// A cloud of the same vertices, with normals, is painted as its mesh is: nearly, as the plane of eight neighbours is
// not the facets.
TEST_F(SurfaceStroke, PointCloudsWithNormalsArePainted) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 8000);
  Mesh cloud;
  cloud.positions = mesh.positions;
  const std::vector<Vec3d> normals = vertex_normals(mesh);
  ReplayOptions options;
  options.normals = normals;
  const ReplayResult painted = replay(cloud, session("paint"), options);
  const ReplayResult expected = replay(mesh, session("paint"));
  ASSERT_EQ(painted.status, AdvectStatus::done);
  EXPECT_EQ(painted.shape.normals().size(), normals.size());
  double worst = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    worst = std::max(worst, norm(painted.shape.positions()[i] - expected.shape.positions()[i]));
  }
  EXPECT_LT(worst, 0.2 * 0.1);
}

// The places decide, not the numbers of vertices.
TEST_F(SurfaceStroke, UnweldedShapesMoveAsWeldedOnes) {
  const Mesh mesh = shape();
  const Mesh unwelded = test::unwelded(mesh);
  std::vector<std::string> lines;
  for (const char* kind : {"paint", "stamp", "slip", "print", "twist"}) lines.push_back(lines_of(kind));
  lines.emplace_back(R"({"relax": {"points": [[0, 0, 1]], "radius": 0.5}})");
  lines.emplace_back(R"({"tool": "inflate", "points": [[0, 0, 1]], "radius": 0.4, "volume": 0.01})");
  for (const std::string& line : lines) {
    const std::vector<Vec3d> expected = replay(mesh, session_of(line + "\n")).shape.positions();
    const std::vector<Vec3d> moved = replay(unwelded, session_of(line + "\n")).shape.positions();
    EXPECT_LT(test::farthest_apart(mesh, expected, moved), 1e-6) << line;
    EXPECT_GT(test::farthest_apart(mesh, mesh.positions, moved), 1e-4) << line;
  }
}

// The two sides of a sheet have normals that cancel where they share places.
TEST_F(SurfaceStroke, ASheetOfTwoSidesIsPainted) {
  const Mesh front{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 3, 6}, {0, 1, 2, 0, 2, 3}, {}};
  Mesh sheet = test::unwelded(front);
  const std::vector<Vec3d> there = sheet.positions;
  for (std::uint32_t t = 0; t < 6; t += 3) {
    for (const std::uint32_t c : {0U, 2U, 1U}) {
      sheet.positions.push_back(there[t + c]);
      sheet.corner_vertex.push_back(static_cast<std::uint32_t>(sheet.positions.size() - 1));
    }
    sheet.face_begin.push_back(static_cast<std::uint32_t>(sheet.corner_vertex.size()));
  }
  const Session painting =
      session_of(R"({"tool": "paint", "outer": 2, "depth": -0.1, "path": [[0.4, 0.3, 0.1], [0.6, 0.3, 0.1]]})"
                 "\n");
  const std::vector<Vec3d> moved = replay(sheet, painting).shape.positions();
  EXPECT_GT(moved[0].z, 0.01);
}

}  // namespace
}  // namespace knead::surface_stroke_test
