// Reports and their JSON.
#include "knead/certify.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "knead/flow.h"
#include "knead/mesh.h"
#include "support/unwelded.h"

namespace knead::report_test {
namespace {

Session one_stroke() {
  Session session;
  SessionStroke& stroke = session.strokes.emplace_back();
  stroke.stroke = ImplicitStroke{{{1, 0, 0}, {1.3, 0, 0}, {1.5, 0, 0}}, 0.2, 0.6};
  stroke.line = 2;
  return session;
}

TEST(Report, HasTheKeysOfTheCommand) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 2562);
  ReplayOptions options;
  options.motion.threads = 1;
  const ReplayResult result = replay(mesh, one_stroke(), options);
  const auto json = nlohmann::json::parse(to_json(make_report(mesh, result, options, {1, 2, 3, 4, 10})));
  EXPECT_EQ(json.size(), 26u);
  EXPECT_EQ(json.at("vertices"), mesh.vertex_count());
  EXPECT_EQ(json.at("faces"), mesh.face_count());
  EXPECT_GT(json.at("moved_vertices"), 10);
  EXPECT_LT(json.at("moved_vertices"), mesh.vertex_count() / 2);
  EXPECT_EQ(json.at("strokes"), 1);
  EXPECT_EQ(json.at("segments"), 2);
  EXPECT_EQ(json.at("vertex_steps"), result.shape.work().accepted_steps);
  EXPECT_DOUBLE_EQ(json.at("steps_mean").get<double>() * static_cast<double>(mesh.vertex_count()),
                   json.at("vertex_steps").get<double>());
  EXPECT_GE(json.at("steps_max"), json.at("steps_mean"));
  EXPECT_GT(json.at("evaluations"), json.at("vertex_steps"));
  EXPECT_GE(json.at("rejected_steps"), 0);
  EXPECT_EQ(json.at("seconds"),
            (nlohmann::json{{"read", 1.0}, {"deform", 2.0}, {"write", 3.0}, {"measure", 4.0}, {"total", 10.0}}));
  EXPECT_EQ(json.at("threads"), 1);
  EXPECT_EQ(json.at("simd"), simd_name());
  EXPECT_EQ(json.at("backend"), "cpu");
  EXPECT_EQ(json.at("precision"), "float");
  EXPECT_EQ(json.at("tolerance"), 1e-5);
  EXPECT_NEAR(json.at("volume_error").get<double>(), 0, 0.02);  // the sampling error of a coarse sphere
  EXPECT_DOUBLE_EQ(json.at("volume_error").get<double>(),
                   json.at("volume_after").get<double>() / json.at("volume_before").get<double>() - 1);
  EXPECT_GT(json.at("area_after"), json.at("area_before"));
  EXPECT_NEAR(json.at("max_displacement").get<double>(), 0.5, 1e-4);  // the rigid core's way
  EXPECT_GT(json.at("greatest_stretch"), 1.5);
  EXPECT_LT(json.at("greatest_stretch"), 10);
  EXPECT_EQ(json.at("flipped_triangles"), 0);
  EXPECT_TRUE(json.at("self_intersections_before").is_null());
  EXPECT_TRUE(json.at("self_intersections_after").is_null());
}

// All of the ball is in the inner region, which is stretched by the factor.
TEST(Report, HasTheGreatestStretchOfATriangle) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 2562);
  Session session;
  session.strokes.push_back({StretchStroke{{0, 0, 0}, {0, 0, 1}, 2.5, 3, 4}});
  const ReplayOptions options;
  const ReplayResult result = replay(mesh, session, options);
  EXPECT_NEAR(make_report(mesh, result, options, {}).greatest_stretch.value(), 2.5, 1e-3);
  Mesh cloud = mesh;
  cloud.corner_vertex.clear();
  cloud.face_begin.resize(1);
  EXPECT_FALSE(make_report(cloud, replay(cloud, session, options), options, {}).greatest_stretch);
}

// Remeshing keeps the places at the start, so that stretches are those of the shape that was not remeshed.
TEST(Report, KnowsTheStretchOfARemeshedShape) {
  const Mesh mesh = make_shape(ShapeKind::sphere, 2562);
  Session session;
  session.strokes.push_back({StretchStroke{{0, 0, 0}, {0, 0, 1}, 2.5, 3, 4}});
  session.strokes.push_back({StretchStroke{{0, 0, 0}, {0, 0, 1}, 1.5, 4, 5}});
  ReplayOptions options;
  options.remesh.settings = RemeshSettings{};
  options.remesh.settings->max_edge = 0.06;
  const ReplayResult result = replay(mesh, session, options);
  ASSERT_TRUE(result.shape.is_remeshed());
  ASSERT_GT(result.shape.positions().size(), 2 * mesh.vertex_count());
  EXPECT_NEAR(make_report(mesh, result, options, {}).greatest_stretch.value(), 2.5 * 1.5, 0.05 * 2.5 * 1.5);
  const Provenance& provenance = *result.shape.provenance();
  ASSERT_EQ(provenance.rest.size(), result.shape.positions().size());
  ASSERT_EQ(provenance.before_stroke.size(), result.shape.positions().size());
  for (std::size_t i = 0; i < provenance.rest.size(); ++i) {
    ASSERT_NEAR(provenance.before_stroke[i].z, 2.5 * provenance.rest[i].z, 0.03);
    ASSERT_NEAR(result.shape.positions()[i].z, 1.5 * provenance.before_stroke[i].z, 0.03);
  }
}

// The image of its lowest corner is as far from the chord of its longest edge as the remesh allows.
TEST(Report, TheStretchOfASliverOfARemeshedShapeDoesNotCount) {
  const Mesh ball = make_shape(ShapeKind::sphere, 2562);
  Session session;
  session.strokes.push_back({TwistStroke{{0, 0, 0}, {0, 0, 1}, 60, -0.8, 0.8}});
  const auto stretch_of = [&](const Mesh& mesh) {
    ReplayOptions options;
    options.remesh.settings.emplace().iterations = 0;
    const ReplayResult result = replay(mesh, session, options);
    EXPECT_TRUE(result.shape.is_remeshed());
    return make_report(mesh, result, options, {}).greatest_stretch.value();
  };
  Mesh with_slivers;
  with_slivers.positions = ball.positions;
  for (const Triangle& t : triangulate(ball)) {
    if (with_slivers.face_count() % 50 != 0) {
      with_slivers.add_face(t);
      continue;
    }
    const Vec3d& a = ball.positions[t[0]];
    const Vec3d& b = ball.positions[t[1]];
    const Vec3d& c = ball.positions[t[2]];
    const auto low = static_cast<std::uint32_t>(with_slivers.vertex_count());
    with_slivers.positions.push_back((a + b) * 0.5 + (c - a) * 1e-3);
    with_slivers.add_face(Triangle{t[0], t[1], low});
    with_slivers.add_face(Triangle{t[1], t[2], low});
    with_slivers.add_face(Triangle{t[2], t[0], low});
  }
  EXPECT_NEAR(stretch_of(with_slivers), stretch_of(ball), 0.05);
}

TEST(Report, HasNoVolumeErrorWhereTheShapeIsOpen) {
  Mesh mesh = make_shape(ShapeKind::sphere, 162);
  mesh.corner_vertex.resize(mesh.corner_vertex.size() - 3);
  mesh.face_begin.pop_back();
  const ReplayOptions options;
  const Report report = make_report(mesh, replay(mesh, one_stroke(), options), options, {});
  EXPECT_FALSE(report.volume_error);
  EXPECT_TRUE(nlohmann::json::parse(to_json(report)).at("volume_error").is_null());
  EXPECT_GT(report.threads, 0);
}

TEST(Report, UnweldedShapesAreWhatTheirPlacesAre) {
  const Mesh sphere = make_shape(ShapeKind::sphere, 162);
  const Mesh soup = test::unwelded(sphere);
  const ReplayOptions options;
  const Report report = make_report(soup, replay(soup, one_stroke(), options), options, {});
  const Report expected = make_report(sphere, replay(sphere, one_stroke(), options), options, {});
  ASSERT_TRUE(report.volume_error);
  EXPECT_NEAR(*report.volume_error, *expected.volume_error, 1e-6);
  const SurfaceCheck check = check_surface(soup, describe(soup));
  EXPECT_TRUE(check.info.measures.closed());
  EXPECT_EQ(check.info.measures.unused_vertices, 0U);
  EXPECT_EQ(check.info.measures.vertices, soup.vertex_count());
  EXPECT_EQ(check.self_intersections.count, 0U);
  ASSERT_EQ(check.info.notes.size(), 1U);
  EXPECT_NE(check.info.notes[0].find("each place counts as one vertex"), std::string::npos);
}

TEST(Report, OfNothingIsZero) {
  const ReplayOptions options;
  const Report report = make_report({}, replay(Mesh(), {}, options), options, {});
  EXPECT_EQ(report.vertices, 0u);
  EXPECT_EQ(report.steps_mean, 0);
  EXPECT_EQ(report.max_displacement, 0);
  EXPECT_FALSE(report.volume_error);
}

}  // namespace
}  // namespace knead::report_test
