// Relaxing: the volume stays, nothing crosses, triangles get better, and every way to the result gives the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace knead::relax_test {
namespace {

constexpr double kVolume = 1e-6;  // relative; rounding alone is a millionth of it

// A sphere of radius 1 whose vertices are moved at random by at most a part of an edge.
Mesh rough_sphere(double roughness, std::size_t vertices = 2562) {
  Mesh mesh = make_shape(ShapeKind::sphere, vertices);
  std::mt19937_64 random(5);
  const double reach = roughness * std::sqrt(4 * 3.14 / static_cast<double>(vertices));
  std::uniform_real_distribution<double> by(-reach, reach);
  for (Vec3d& p : mesh.positions) p += Vec3d{by(random), by(random), by(random)};
  return mesh;
}

// A square of n x n cells in z = 0, rough inside, cut into triangles.
Mesh rough_square(std::uint32_t n) {
  Mesh mesh;
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> by(-0.3, 0.3);
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      const bool inside = i > 0 && j > 0 && i < n && j < n;
      const Vec3d d = inside ? Vec3d{by(random), by(random), by(random)} : Vec3d{};
      mesh.positions.push_back((Vec3d{static_cast<double>(i), static_cast<double>(j), 0} + d) / n);
    }
  }
  mesh.face_begin = {0};
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      for (const std::uint32_t v : {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1}) {
        mesh.corner_vertex.push_back(v);
        if (mesh.corner_vertex.size() % 3 == 0) {
          mesh.face_begin.push_back(static_cast<std::uint32_t>(mesh.corner_vertex.size()));
        }
      }
    }
  }
  return mesh;
}

// How high the bumps of a square are within a third of the radius after ten dabs in its middle, of what they were.
double left_of_bumps(std::uint32_t n, double radius) {
  Mesh mesh = rough_square(n);
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
    const double x = static_cast<double>(i % (n + 1)) / n;
    const double y = static_cast<double>(i / (n + 1)) / n;
    const double turns = 4 * 3.14159265 / radius;
    mesh.positions[i] = {x, y, 0.02 * radius * std::cos(turns * (x - 0.5)) * std::cos(turns * (y - 0.5))};
  }
  const Vec3d middle{0.5, 0.5, 0};
  const auto within = [&](const Vec3d& p, double r) { return norm(Vec3d{p.x, p.y, 0} - middle) < r; };
  const auto height = [&](std::span<const Vec3d> positions) {
    double sum = 0;
    for (const Vec3d& p : positions) sum += within(p, radius / 3) ? p.z * p.z : 0;
    return std::sqrt(sum);
  };
  const std::vector<Vec3d>& all = mesh.positions;
  const auto count = std::count_if(all.begin(), all.end(), [&](const Vec3d& p) { return within(p, radius); });
  RelaxStroke stroke{.points = std::vector<Vec3d>(10, middle), .radius = radius, .amount = 1};
  stroke.iterations = relax_iterations(static_cast<std::size_t>(count));
  Session session;
  session.strokes = {{stroke}};
  return height(replay(mesh, session).shape.positions()) / height(mesh.positions);
}

TEST(Relax, TenDabsRemoveABumpWhateverTheMesh) {
  for (const std::uint32_t n : {100U, 190U, 300U}) EXPECT_LT(left_of_bumps(n, 0.3), 0.1) << n;
}

RelaxStroke across(double radius, int points = 7) {
  RelaxStroke stroke;
  stroke.radius = radius;
  for (int i = 0; i < points; ++i) {
    const double angle = 0.1 * i;
    stroke.points.push_back({std::sin(angle), 0.05 * i, std::cos(angle)});
  }
  return stroke;
}

Session session_of(const std::vector<Stroke>& strokes) {
  Session session;
  session.name = "relax.knead";
  for (const Stroke& stroke : strokes) session.strokes.push_back({stroke, session.strokes.size() + 2});
  return session;
}

Mesh relaxed(const Mesh& mesh, const RelaxStroke& stroke, int threads = 0) {
  ReplayOptions options;
  options.motion.threads = threads;
  const ReplayResult result = replay(mesh, session_of({stroke}), options);
  EXPECT_EQ(result.status, AdvectStatus::done);
  EXPECT_FALSE(result.shape.is_remeshed());
  return result.shape.to_mesh();
}

std::size_t crossings(const Mesh& mesh) { return self_intersections(triangulate(mesh), mesh.positions).count; }

double distance_to(const Vec3d& p, const std::vector<Vec3d>& points) {
  double least = HUGE_VAL;
  for (const Vec3d& q : points) least = std::min(least, norm(p - q));
  return least;
}

// The root of the mean square of how far vertices near the middle of the path are from the unit sphere.
double roughness(const Mesh& mesh, const RelaxStroke& stroke) {
  double squares = 0;
  double count = 0;
  for (const Vec3d& p : mesh.positions) {
    if (distance_to(p, stroke.points) > 0.6 * stroke.radius) continue;
    squares += (norm(p) - 1) * (norm(p) - 1);
    ++count;
  }
  return std::sqrt(squares / count);
}

double worst_angle(const Mesh& mesh, const RelaxStroke& stroke) {
  Mesh near = mesh;
  near.corner_vertex.clear();
  near.face_begin = {0};
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const bool is_in = std::all_of(face.begin(), face.end(), [&](std::uint32_t v) {
      return distance_to(mesh.positions[v], stroke.points) < 0.6 * stroke.radius;
    });
    if (!is_in) continue;
    near.corner_vertex.insert(near.corner_vertex.end(), face.begin(), face.end());
    near.face_begin.push_back(static_cast<std::uint32_t>(near.corner_vertex.size()));
  }
  return measure(near).smallest_angle_deg.value_or(0);
}

TEST(Relax, SmoothsTheSurfaceAndItsTrianglesAndKeepsTheVolume) {
  const Mesh rough = rough_sphere(0.25);
  const RelaxStroke stroke = across(0.4);
  const Mesh smooth = relaxed(rough, stroke);
  EXPECT_LT(roughness(smooth, stroke), 0.5 * roughness(rough, stroke));
  EXPECT_GT(worst_angle(smooth, stroke), 1.5 * worst_angle(rough, stroke));
  EXPECT_NEAR(measure(smooth).volume / measure(rough).volume, 1, kVolume);
  EXPECT_EQ(crossings(smooth), crossings(rough));
  EXPECT_EQ(smooth.corner_vertex, rough.corner_vertex);
}

TEST(Relax, MovesNothingOutsideTheRadius) {
  const Mesh rough = rough_sphere(0.25);
  const RelaxStroke stroke = across(0.3);
  const Mesh smooth = relaxed(rough, stroke);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < rough.positions.size(); ++i) {
    if (smooth.positions[i] == rough.positions[i]) continue;
    ++moved;
    EXPECT_LT(distance_to(rough.positions[i], stroke.points), stroke.radius);
  }
  EXPECT_GT(moved, 100U);
}

TEST(Relax, WithoutSurfaceMovesVerticesInTheSurfaceOnly) {
  const Mesh rough = rough_sphere(0);  // smooth: its vertices lie on the sphere
  RelaxStroke stroke = across(0.5);
  stroke.surface = 0;
  stroke.iterations = 10;
  const Mesh smooth = relaxed(rough, stroke);
  double most = 0;
  for (const Vec3d& p : smooth.positions) most = std::max(most, std::abs(norm(p) - 1));
  EXPECT_NE(smooth.positions, rough.positions);
  EXPECT_LT(most, 2e-4);  // an edge of 0.07 lies 6e-4 below the sphere; vertices move by a part of one
  EXPECT_NEAR(measure(smooth).volume / measure(rough).volume, 1, kVolume);
}

TEST(Relax, GivesTheSameBitsForEveryNumberOfThreads) {
  const Mesh rough = rough_sphere(0.3, 40962);
  const RelaxStroke stroke = across(0.6);
  const Mesh one = relaxed(rough, stroke, 1);
  EXPECT_TRUE(relaxed(rough, stroke, 2).positions == one.positions);
  EXPECT_TRUE(relaxed(rough, stroke, 7).positions == one.positions);
}

TEST(Relax, NeverMakesTrianglesCross) {
  // Two sheets that nearly touch, with ripples that smoothing would push into each other.
  Mesh mesh = rough_square(30);
  const Mesh sheet = mesh;
  const auto count = static_cast<std::uint32_t>(sheet.vertex_count());
  for (Vec3d p : sheet.positions) {
    p.z += 0.02 + 0.015 * std::sin(40 * p.x);
    mesh.positions.push_back(p);
  }
  for (const std::uint32_t v : sheet.corner_vertex) mesh.corner_vertex.push_back(v + count);
  for (std::size_t f = 1; f < sheet.face_begin.size(); ++f) {
    mesh.face_begin.push_back(sheet.face_begin.back() + sheet.face_begin[f]);
  }
  const SelfIntersections before = self_intersections(triangulate(mesh), mesh.positions);
  RelaxStroke stroke{{{0.5, 0.5, 0}, {0.4, 0.5, 0.02}, {0.6, 0.5, 0.02}}, 0.35, 1, 1, 12};
  const Mesh smooth = relaxed(mesh, stroke);
  EXPECT_NE(smooth.positions, mesh.positions);
  const SelfIntersections after = self_intersections(triangulate(smooth), smooth.positions);
  EXPECT_TRUE(std::includes(before.pairs.begin(), before.pairs.end(), after.pairs.begin(), after.pairs.end()));
}

TEST(Relax, KeepsBoundariesOfAnOpenSurface) {
  const Mesh rough = rough_square(20);
  const RelaxStroke stroke{{{0.5, 0.5, 0}}, 2, 0.7, 1, 20};
  const Mesh smooth = relaxed(rough, stroke);
  double before = 0;
  double after = 0;
  double flux = 0;
  for (std::size_t i = 0; i < rough.positions.size(); ++i) {
    const Vec3d& p = rough.positions[i];
    const bool on_boundary = p.x == 0 || p.y == 0 || p.x == 1 || p.y == 1;
    EXPECT_TRUE(!on_boundary || smooth.positions[i] == p);
    before += p.z * p.z;
    after += smooth.positions[i].z * smooth.positions[i].z;
  }
  for_each_triangle(rough, rough.positions, [&](const Triangle& t) {
    const auto six = [&](const Mesh& m) { return dot(m.positions[t[0]], cross(m.positions[t[1]], m.positions[t[2]])); };
    flux += six(smooth) - six(rough);
  });
  EXPECT_LT(after, 0.1 * before);
  EXPECT_NEAR(flux / 6, 0, kVolume * 0.01);
}

TEST(Relax, KeepsCreasesOnTheirLines) {
  const Mesh box = make_shape(ShapeKind::box, 2000);
  Mesh rough = box;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> by(-0.012, 0.012);
  Vec3d half{};
  for (const Vec3d& p : box.positions) half = {std::max(half.x, p.x), std::max(half.y, p.y), std::max(half.z, p.z)};
  // Within the sides, so that the box keeps its shape.
  for (Vec3d& p : rough.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(p[axis]) < 0.999 * half[axis]) p[axis] += by(random);
    }
  }
  const Mesh smooth = relaxed(rough, {{{half.x, half.y, 0}}, 10, 0.5, 1, 10});
  std::size_t slid = 0;
  for (std::size_t i = 0; i < rough.positions.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(rough.positions[i][axis]) < 0.999 * half[axis]) continue;
      EXPECT_NEAR(smooth.positions[i][axis], rough.positions[i][axis], 1e-9);
    }
    slid += smooth.positions[i] != rough.positions[i] ? 1 : 0;
  }
  EXPECT_GT(slid, 500U);
  EXPECT_NEAR(measure(smooth).volume / measure(rough).volume, 1, kVolume);
  EXPECT_GT(*measure(smooth).smallest_angle_deg, *measure(rough).smallest_angle_deg);
}

TEST(Relax, RefusesAPointCloudAndTheWayBack) {
  Mesh cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}};
  const auto error = [](const Mesh& mesh, const ReplayOptions& options) -> std::string {
    try {
      replay(mesh, session_of({across(0.5)}), options);
    } catch (const InvalidInput& refused) {
      return refused.what();
    }
    return "";
  };
  EXPECT_EQ(error(cloud, {}), "relax.knead:2: a point cloud has no surface to relax; remove this line");
  ReplayOptions back;
  back.part.direction = Direction::backwards;
  EXPECT_TRUE(
      error(rough_sphere(0), back).starts_with("relax.knead:2: a relax is no flow, so it cannot be taken back"));
}

TEST(Relax, PiecesAndFramesGiveTheSameBits) {
  const Mesh rough = rough_sphere(0.2);
  const RelaxStroke whole = across(0.35, 8);
  const Mesh expected = relaxed(rough, whole);
  RelaxStroke first = whole;
  first.points.resize(3);
  RelaxStroke rest = whole;
  rest.points.erase(rest.points.begin(), rest.points.begin() + 3);
  const ReplayResult pieces = replay(rough, session_of({first, rest}));
  EXPECT_TRUE(pieces.shape.positions() == expected.positions);

  ReplayOptions options;
  std::vector<std::vector<Vec3d>> frames;
  options.frames = {9, Ease::linear, 0, false,
                    [&](const ReplayFrame& frame) { frames.push_back(frame.shape.positions()); }};
  EXPECT_TRUE(replay(rough, session_of({whole}), options).shape.positions() == expected.positions);
  ASSERT_EQ(frames.size(), 9U);
  EXPECT_TRUE(frames.front() == rough.positions);
  EXPECT_TRUE(frames.back() == expected.positions);
  ReplayOptions half;
  half.part.until = 0.5;
  EXPECT_TRUE(replay(rough, session_of({whole}), half).shape.positions() == frames[4]);
  half.part.until = 0.5 / 8;
  const std::vector<Vec3d> part = replay(rough, session_of({whole}), half).shape.positions();
  EXPECT_TRUE(part != rough.positions && part != frames[1]);
}

TEST(Relax, IsAStrokeOfTheHistory) {
  const Mesh rough = rough_sphere(0.2);
  Workbench bench(rough);
  const RelaxStroke whole = across(0.35, 6);
  std::vector<SessionStroke> lines;
  const auto follow = [&](const WorkResult& result) {
    ASSERT_TRUE(result.is_done()) << result.refusal;
    ASSERT_LE(result.lines.undone, lines.size());
    lines.resize(lines.size() - result.lines.undone);
    lines.insert(lines.end(), result.lines.appended.begin(), result.lines.appended.end());
  };
  for (std::size_t count = 1; count <= whole.points.size(); ++count) {
    RelaxStroke so_far = whole;
    so_far.points.resize(count);
    follow(bench.set_live({{so_far}}));
  }
  EXPECT_EQ(lines.size(), whole.points.size());  // only what is new was appended
  follow(bench.finish());
  EXPECT_TRUE(bench.state().positions.copy() == relaxed(rough, whole).positions);
  ASSERT_EQ(bench.strokes().size(), 1U);
  EXPECT_EQ(std::get<RelaxStroke>(bench.strokes().front().stroke), whole);
  EXPECT_EQ(strokes_of_gestures(lines).size(), 1U);
  follow(bench.append({{ImplicitStroke{{{1, 0, 0}, {1.2, 0, 0}}, 0.2, 0.6}}}));
  const std::vector<Vec3d> last = bench.state().positions.copy();
  follow(bench.undo());
  follow(bench.undo());
  EXPECT_TRUE(bench.state().positions.copy() == rough.positions);
  follow(bench.redo());
  follow(bench.redo());
  EXPECT_TRUE(bench.state().positions.copy() == last);
}

TEST(Relax, ARefusalAfterItLeavesTheShapeAsItWas) {
  Workbench bench(rough_sphere(0.2));
  const std::vector<Vec3d> before = bench.state().positions.copy();
  HandlesStroke impossible;
  impossible.full_vertices = {1'000'000};
  impossible.zero_vertices = {1};
  impossible.motion = HandlesTranslation{{1, 0, 0}};
  EXPECT_FALSE(bench.append({{across(0.3)}, {impossible}}).is_done() && bench.done().size() != 1);
  EXPECT_FALSE(bench.set_live({{across(0.3)}, {impossible}}).is_done());
  bench.set_live({});
  while (bench.can_undo()) bench.undo();
  EXPECT_TRUE(bench.state().positions.copy() == before);
}

TEST(Relax, HasACertificate) {
  const Mesh rough = rough_sphere(0.2);
  ReplayOptions options;
  CertificateBuilder builder(rough, options);
  options.on_stroke = [&](const AppliedStroke& stroke) { builder.add(stroke); };
  const ReplayResult result = replay(rough, session_of({across(0.35)}), options);
  const Certificate certificate = builder.finish(result, false);
  EXPECT_EQ(certificate.motion_outside, 0);
  EXPECT_EQ(certificate.volume_error_integration, 0);
  EXPECT_NEAR(certificate.volume_error.value_or(1), 0, kVolume);
  EXPECT_LE(certificate.crossings_after, certificate.crossings_before);
  ASSERT_EQ(certificate.strokes.size(), 1U);
  EXPECT_EQ(certificate.strokes.front().points, 0U);  // it has no true image to be compared with
  EXPECT_EQ(result.segments, 0U);
  EXPECT_TRUE(result.resolved.empty());
}

TEST(Relax, IsCancelledBetweenPlaces) {
  Progress progress;
  progress.cancel = true;
  DeformedShape shape(std::make_shared<const Mesh>(rough_sphere(0.2)));
  EXPECT_EQ(shape.relax(across(0.3), 0, 7, &progress), AdvectStatus::cancelled);
  EXPECT_EQ(shape.dabs(), 0U);
}

}  // namespace
}  // namespace knead::relax_test
