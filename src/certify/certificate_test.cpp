// Certificates: their statements on sound and damaged results.
#include "knead/certify.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/test_shapes.h"

namespace knead::certificate_test {
namespace {

Session session_of(const std::vector<Stroke>& strokes) {
  Session session;
  session.name = "s.knead";
  for (const Stroke& stroke : strokes) {
    SessionStroke& added = session.strokes.emplace_back();
    added.stroke = stroke;
    added.line = session.strokes.size() + 1;
  }
  return session;
}

Mesh ball(std::size_t vertices = 2562) { return make_shape(ShapeKind::sphere, vertices); }

const Stroke kPull = ImplicitStroke{{{1, 0, 0}, {1.4, 0, 0}}, 0.2, 0.7};
const Stroke kTurn = RotateStroke{{0, 1, 0}, {0, 1, 0}, 60, 0.2, 0.8};

struct Certified {
  ReplayResult result;
  Certificate certificate;
};

Certified certify(const Mesh& mesh, const Session& session, ReplayOptions options = {}, bool as_float = true,
                  std::size_t max_points = std::numeric_limits<std::size_t>::max()) {
  CertificateBuilder builder(mesh, options, max_points);
  options.on_stroke = [&](const AppliedStroke& stroke) { builder.add(stroke); };
  Certified certified{replay(mesh, session, options), {}};
  certified.certificate = builder.finish(certified.result, as_float);
  return certified;
}

ReplayOptions remeshing() {
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  return options;
}

TEST(Certificate, OfAGoodDeformation) {
  for (const ReplayOptions& options : {ReplayOptions{}, remeshing()}) {
    const Certificate c = certify(ball(), session_of({kPull, kTurn}), options).certificate;
    EXPECT_EQ(c.crossings_before, 0u);
    EXPECT_EQ(c.crossings_after, 0u);
    EXPECT_EQ(c.flipped_triangles, 0u);
    EXPECT_EQ(c.degenerate_after, 0u);
    EXPECT_TRUE(c.closed_before && c.closed_after);
    EXPECT_EQ(c.euler_before, 2);
    EXPECT_EQ(c.euler_after, 2);
    EXPECT_EQ(c.motion_outside, 0);
    ASSERT_TRUE(c.volume_error && c.volume_error_sampling);
    EXPECT_NEAR(c.volume_error_integration + *c.volume_error_sampling, *c.volume_error, 1e-15);
    EXPECT_LT(std::abs(c.volume_error_integration), 1e-5);
    ASSERT_TRUE(c.smallest_angle_before && c.smallest_angle_after && c.touched_angle_before && c.touched_angle_after);
    constexpr double rounding = 1 - 1e-12;
    EXPECT_GE(*c.touched_angle_before, *c.smallest_angle_before * rounding);
    EXPECT_GE(*c.touched_angle_after, *c.smallest_angle_after * rounding);
    ASSERT_EQ(c.strokes.size(), 2u);
    EXPECT_EQ(c.strokes[0].line, 2u);
    EXPECT_EQ(c.strokes[1].line, 3u);
    for (const StrokeDistance& stroke : c.strokes) {
      EXPECT_GT(stroke.points, 100u);
      EXPECT_LE(stroke.rms, stroke.max);
      EXPECT_LE(stroke.max, c.distance_max);
    }
    EXPECT_GT(c.distance_rms, 0);
    EXPECT_LE(c.distance_rms, c.distance_max);
  }
}

// Chords of long edges miss the true image; remeshing brings them to it.
TEST(Certificate, TheDistanceFallsWhereTheMeshFollows) {
  const Session session = session_of({kPull});
  const double as_it_is = certify(ball(642), session).certificate.distance_rms;
  const double finer = certify(ball(10242), session).certificate.distance_rms;
  const double remeshed = certify(ball(642), session, remeshing()).certificate.distance_rms;
  EXPECT_LT(finer, as_it_is / 8);  // a quarter of the edges: a sixteenth of the distance
  EXPECT_LT(remeshed, as_it_is / 2);
}

// Of a part of the points the distances are about those of all.
TEST(Certificate, APartOfThePointsShowsTheDistance) {
  for (const ReplayOptions& options : {ReplayOptions{}, remeshing()}) {
    const Certificate all = certify(ball(), session_of({kTurn}), options).certificate;
    const Certificate part = certify(ball(), session_of({kTurn}), options, true, 500).certificate;
    EXPECT_GT(all.strokes.at(0).points, 1000u);
    EXPECT_LE(part.strokes.at(0).points, 500u);
    EXPECT_NEAR(part.distance_rms / all.distance_rms, 1, 0.2);
    EXPECT_LE(part.distance_max, all.distance_max * (1 + 1e-9));
    EXPECT_EQ(part.volume_error, all.volume_error);
  }
}

// The corners of a box rest; the vertices that refining adds between them grow to the square of what was asked for.
TEST(Certificate, SaysByHowMuchPiecesGrowBetweenTheCorners) {
  CurveStroke thicker;
  thicker.from = {{0.1, 0.5, 0.5}, {0.9, 0.5, 0.5}};
  thicker.fixed = CurveFixed::start;
  thicker.keep = CurveKeeps::length;
  thicker.thickness_before = 1;
  thicker.thickness = 1.2;
  const Certificate c = certify(unit_cube(), session_of({thicker}), remeshing()).certificate;
  ASSERT_TRUE(c.det_least && c.det_greatest);
  EXPECT_NEAR(*c.det_greatest, 1.44, 1e-6);
  EXPECT_LT(*c.det_least, 1.2);
}

// A stroke that moves the whole shape as it is: nothing is lost but the tolerance.
TEST(Certificate, OfARigidMotionIsExact) {
  const Certificate c = certify(ball(642), session_of({ImplicitStroke{{{0, 0, 0}, {0.5, 0, 0}}, 2, 4}})).certificate;
  EXPECT_LT(c.distance_max, 1e-7);
  EXPECT_EQ(c.volume_error_integration, 0);
  EXPECT_NEAR(*c.volume_error, 0, 1e-6);  // positions as float
  EXPECT_EQ(c.strokes.at(0).points, 642u + 1280u);
}

// The sheet's normals cancel at every vertex, and its volume is zero but for rounding.
TEST(Certificate, ASheetWithTwoSidesHasNoVolumeAndNothingFlipped) {
  Mesh sheet = ball();
  for (std::uint32_t f = 0; f < 5120; ++f) {
    const auto face = sheet.face(f);
    sheet.add_face(std::array{face[2], face[1], face[0]});
  }
  const Certified thin = certify(sheet, session_of({kPull}), remeshing());
  EXPECT_FALSE(thin.certificate.volume_error.has_value());
  EXPECT_EQ(thin.certificate.flipped_triangles, 0u);
  EXPECT_LT(thin.certificate.distance_max, 1e-3);
}

// The surface is pushed through itself where the mesh is too coarse to follow.
TEST(Certificate, FindsCrossingsAndFlippedTriangles) {
  const Stroke through = ImplicitStroke{{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {-1, -1, 0}}, 0.3, 0.7};
  const Certified coarse = certify(ball(642), session_of({through}));
  EXPECT_GT(coarse.certificate.crossings_after, 0u);
  EXPECT_GT(coarse.certificate.flipped_triangles, 0u);
  EXPECT_EQ(coarse.certificate.crossings_before, 0u);
  EXPECT_GT(coarse.certificate.distance_max, 0.01);
}

// Random brushes and pushes on shapes of which two cross themselves already, with positions in float and in double.
TEST(Certificate, CountsTheCrossingsOfTheWholeShape) {
  const std::vector<Mesh> shapes{pushed_through(), make_shape(ShapeKind::hand, 4000),
                                 join(quad_torus(24, 12), quad_torus(20, 14), {0.7, 0.3, 0.1})};
  std::mt19937 random(17);
  std::uniform_real_distribution<double> number(-1, 1);
  std::size_t changes = 0;
  for (const Mesh& mesh : shapes) {
    const double size = bounding_box(mesh.positions).diagonal();
    for (int i = 0; i < 6; ++i) {
      const Vec3d from = mesh.positions[random() % mesh.vertex_count()];
      const Vec3d by = Vec3d{number(random), number(random), number(random)} * (0.3 * size);
      const Stroke stroke = ImplicitStroke{{from, from + by}, 0.05 * size, (i % 2 == 0 ? 0.1 : 0.3) * size};
      const bool as_float = i >= 4;
      const Certified certified = certify(mesh, session_of({stroke}), i == 3 ? remeshing() : ReplayOptions{}, as_float);
      Mesh after = certified.result.shape.to_mesh();
      for (Vec3d& p : after.positions) p = as_float ? Vec3d(Vec3<float>(p)) : p;
      const Certificate& c = certified.certificate;
      EXPECT_EQ(c.crossings_before, self_intersections(triangulate(mesh), mesh.positions).count);
      EXPECT_EQ(c.crossings_after, self_intersections(triangulate(after), after.positions).count) << i;
      changes += c.crossings_before != c.crossings_after ? 1 : 0;
    }
  }
  EXPECT_GT(changes, shapes.size());  // or it would show nothing
}

TEST(Certificate, TheIntegrationsShareFallsWithTheTolerance) {
  ReplayOptions loose;
  loose.motion.relative_tolerance = 1e-2;
  loose.motion.integrator = Integrator::rk4;
  ReplayOptions tight;
  tight.motion.relative_tolerance = 1e-9;
  tight.motion.precision = Precision::float64;
  const double drift = std::abs(certify(ball(642), session_of({kPull}), loose).certificate.volume_error_integration);
  const double none = std::abs(certify(ball(642), session_of({kPull}), tight).certificate.volume_error_integration);
  EXPECT_GT(drift, 1e-7);
  EXPECT_LT(none, 1e-9);
}

// Where the limit cylinder ends the inverse flow does not say what came from within; what is known to have moved does.
TEST(Certificate, CarriesBackThroughALimitCylinder) {
  const Mesh bar = make_shape(ShapeKind::box, 6000);
  const Box box = bounding_box(bar.positions);
  TwistStroke twist{{0, 0, 0}, {1, 0, 0}, 10, -0.5, 0.5};
  twist.radius = 2 * box.diagonal();
  const Certificate with = certify(bar, session_of({twist})).certificate;
  twist.radius.reset();
  const Certificate without = certify(bar, session_of({twist})).certificate;
  EXPECT_NEAR(with.distance_rms, without.distance_rms, 1e-12);
  EXPECT_GT(with.strokes.at(0).points, 100u);
  EXPECT_LT(with.distance_max, 0.05);
}

TEST(Certificate, OfAnInverseThroughALimitCylinder) {
  const Mesh hand = make_shape(ShapeKind::hand, 5000);
  BendStroke bend{{0.109, 0.55, -0.012}, {1, 0, 0}, {0, -1, 0}, 80, BendWidth{0.35}};
  bend.radius = 0.125;
  Mesh bent = hand;
  bent.positions = replay(hand, session_of({bend})).shape.positions();
  ReplayOptions options;
  options.part.direction = Direction::backwards;
  const Certificate c = certify(bent, session_of({bend}), options).certificate;
  EXPECT_EQ(c.motion_outside, 0);
  EXPECT_GT(c.strokes.at(0).points, 100u);
  EXPECT_LT(c.distance_rms, 1e-3);
}

TEST(Certificate, IsOfTheShapeAsItIsWritten) {
  const Certificate as_float = certify(ball(642), session_of({kPull}), {}, true).certificate;
  const Certificate as_double = certify(ball(642), session_of({kPull}), {}, false).certificate;
  EXPECT_NE(*as_float.volume_error, *as_double.volume_error);
  EXPECT_NEAR(*as_float.volume_error, *as_double.volume_error, 1e-6);
}

TEST(Certificate, IsInTheReport) {
  const Mesh mesh = ball(642);
  const Certified certified = certify(mesh, session_of({kPull}), remeshing());
  Report report = make_report(mesh, certified.result, remeshing(), {});
  EXPECT_EQ(report.vertices, certified.result.shape.mesh().vertex_count());
  EXPECT_EQ(report.faces, certified.result.shape.mesh().face_count());
  EXPECT_LE(report.moved_vertices, report.vertices);
  EXPECT_GT(report.moved_vertices, report.vertices - mesh.vertex_count());
  EXPECT_GT(report.max_displacement, 0.1);
  EXPECT_LT(report.max_displacement, 0.5);
  report.certificate = certified.certificate;
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json.at("certificate").at("strokes").at(0).at("line"), 2);
  EXPECT_EQ(json.at("certificate").at("crossings_after"), 0);
  EXPECT_EQ(json.at("remesh").at("splits"), certified.result.shape.provenance()->counts.splits);
  EXPECT_DOUBLE_EQ(json.at("remesh").at("volume_error_uncompensated").get<double>(),
                   *report.volume_error - json.at("remesh").at("compensated_volume").get<double>());
}

}  // namespace
}  // namespace knead::certificate_test
